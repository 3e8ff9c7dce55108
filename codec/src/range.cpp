#include "range.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "bits.hpp"

namespace carat {
namespace {

constexpr std::uint32_t kLeastState = 1u << 16;  // states lie in [2^16, 2^32); 16 bits are read at a time
constexpr std::uint32_t kNeighbourWeight = 48;   // steps of activity for each index unit of a neighbour
constexpr int kLeastOffset = -8, kGreatestOffset = 7;  // of contexts, in quarter octaves
constexpr int kMostLanes = 8;

constexpr auto kRawBits = [] {
    std::array<std::uint8_t, kTokens> t{};
    for (int k = 0; k < kTokens; ++k) t[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(raw_bits(k));
    return t;
}();
constexpr auto kMagnitude = [] {
    std::array<std::uint8_t, kTokens> t{};
    for (int k = 0; k < kTokens; ++k) t[static_cast<std::size_t>(k)] = token_magnitude(k);
    return t;
}();

// The context logarithm of kernel::contexts: 8 log2 u, piecewise linear.
int context_log(std::uint32_t u) {
    const int e = static_cast<int>(std::bit_width(u)) - 4;
    return 8 * e + static_cast<int>(u >> e) + 16;
}
// Flat ground has context 8 + offset.
int context_bias(const ActivityScale& scale, int offset) {
    return 2 * (8 + offset) - context_log(24 * scale.step);
}

std::size_t square(int side) { return static_cast<std::size_t>(side) * static_cast<std::size_t>(side); }

void prepare(const RangeInput& in, RangeScratch& s) {
    s.activity.resize(square(in.m - 1));
    kernel::cell_activity(in.known, in.m, ActivityScale(in.radius), s.activity_scratch, s.activity.data());
    if (in.rows < in.m - 1)  // of a matrix smaller than that of the cells, cell (i, j) stands for (i, j)
        for (int i = 1; i < in.rows; ++i)
            std::copy_n(s.activity.begin() + i * (in.m - 1), in.rows, s.activity.begin() + i * in.rows);
    s.context.resize(square(in.rows));
    s.token.resize(square(in.rows));
    s.near.resize(square(in.rows));
    s.magnitude.assign(square(in.rows + 2), 0);
    s.pass_context.resize(square(in.rows));
    s.pass_token.resize(square(in.rows));
}

// Cells of a pass in rows: f(cell, number within the pass). Returns how many.
template <class F>
std::size_t for_pass(int rows, int pass, F f) {
    std::size_t k = 0;
    for (int i = 0; i < rows; ++i) {
        const std::size_t row = static_cast<std::size_t>(i) * static_cast<std::size_t>(rows);
        const auto end = static_cast<std::size_t>(rows);
        for (std::size_t j = static_cast<std::size_t>((i + pass) & 1); j < end; j += 2) f(row + j, k++);
    }
    return k;
}

// Neighbours' magnitudes of second-pass cells from the tokens of the first pass.
void sum_neighbours(int rows, RangeScratch& s) {
    const std::ptrdiff_t side = rows, stride = side + 2;
    for (std::ptrdiff_t i = 0; i < side; ++i)
        for (std::ptrdiff_t j = i & 1; j < side; j += 2)
            s.magnitude[static_cast<std::size_t>((i + 1) * stride + j + 1)] =
                kMagnitude[s.token[static_cast<std::size_t>(i * side + j)]];
    for (std::ptrdiff_t i = 0; i < side; ++i) {
        const std::uint8_t* at = s.magnitude.data() + (i + 1) * stride + 1;
        std::uint8_t* out = s.near.data() + i * side;
        for (std::ptrdiff_t j = 0; j < side; ++j)
            out[j] = static_cast<std::uint8_t>(at[j - 1] + at[j + 1] + at[j - stride] + at[j + stride]);
    }
}

// Contexts of one pass into s.pass_context.
std::size_t pass_contexts(const RangeInput& in, int pass, int offset, RangeScratch& s) {
    const ActivityScale scale(in.radius);
    kernel::contexts(s.activity.data(), pass == 0 ? nullptr : s.near.data(), kNeighbourWeight * scale.step,
                     square(in.rows), context_bias(scale, offset), s.context.data());
    const auto base = static_cast<std::uint8_t>(pass * kPassContexts);
    return for_pass(in.rows, pass, [&](std::size_t cell, std::size_t k) {
        s.pass_context[k] = static_cast<std::uint8_t>(s.context[cell] + base);
    });
}

void make_tokens(std::span<const std::int32_t> index, RangeScratch& s) {
    for (std::size_t k = 0; k < index.size(); ++k)
        s.token[k] = static_cast<std::uint8_t>(token_of(zigzag(index[k])));
}

// Size of the tokens of both passes and their raw bits, 1/256 bit.
std::uint64_t token_cost(const RangeTables::Model& model, const RangeInput& in, int offset, RangeScratch& s) {
    const std::uint16_t* cost = model.encoder().cost.data();
    std::uint64_t sum = 0;
    for (const int pass : {0, 1}) {
        pass_contexts(in, pass, offset, s);
        for_pass(in.rows, pass, [&](std::size_t cell, std::size_t k) {
            sum += cost[std::size_t{s.pass_context[k]} * kTokens + s.token[cell]];
        });
    }
    return sum;
}

struct Choice {
    int offset;
    std::uint64_t cost;
};

// The offset with the least cost near the one given: costs have one valley.
Choice best_offset(const RangeTables::Model& model, const RangeInput& in, RangeScratch& s) {
    Choice best{0, token_cost(model, in, 0, s)};
    for (const int direction : {1, -1}) {
        const int from = best.offset;
        for (int o = from + direction; o >= kLeastOffset && o <= kGreatestOffset; o += direction) {
            const std::uint64_t cost = token_cost(model, in, o, s);
            if (cost >= best.cost) break;
            best = {o, cost};
        }
        if (best.offset != 0) break;
    }
    return best;
}

// States cost 2 bytes each beyond the tokens: few for short matrices.
int log2_lanes_for(std::uint64_t bits) {
    return bits < 8 * 200 ? 0 : bits < 8 * 500 ? 1 : bits < 8 * 1500 ? 2 : 3;
}

// All raw bits, in order of cells.
std::vector<std::byte> write_raw(std::span<const std::int32_t> index, const RangeTables::Model& model,
                                 const RangeScratch& s) {
    (void)model;
    BitWriter bits;
    for (std::size_t k = 0; k < index.size(); ++k) {
        const int count = kRawBits[s.token[k]];
        if (count > 0) bits.put(zigzag(index[k]) - token_base(s.token[k]), count);
    }
    return bits.finish();
}

// Encodes backwards what a decoder reads forwards.
class StateEncoder {
  public:
    StateEncoder(const RangeTables::Model& model, std::vector<std::uint16_t>& words)
        : frequency_(model.frequency[0].data()), encoder_(model.encoder()), words_(words) {}

    void put(std::uint32_t& x, std::size_t context, std::size_t token) {
        const std::size_t at = context * kTokens + token;
        const std::uint32_t f = frequency_[at];
        if (x >= f << 20) {  // f < 2^12
            words_.push_back(static_cast<std::uint16_t>(x));
            x >>= 16;
        }
        const std::uint32_t quotient = x / f, number = x - quotient * f;
        x = (quotient << kFrequencyBits) |
            encoder_.slot[context * kFrequencySum + encoder_.begin[at] + number];
    }

  private:
    const std::uint16_t* frequency_;
    const RangeTables::Model::Encoder& encoder_;
    std::vector<std::uint16_t>& words_;
};

void append(std::vector<std::byte>& out, const void* data, std::size_t bytes) {
    const auto* p = static_cast<const std::byte*>(data);
    out.insert(out.end(), p, p + bytes);
}

// Decoder of tokens; kLanes states take turns.
template <int kLanes>
class TokenDecoder {
  public:
    TokenDecoder(const RangeTables::Model& model, std::span<const std::byte> bytes)
        : cutoff_(model.cutoff.data()), entry_(model.entries.data()) {
        if (bytes.size() < kLanes * sizeof(std::uint32_t))
            throw Error(ErrorCode::truncated, "range code ends inside its states");
        std::memcpy(state_.data(), bytes.data(), kLanes * sizeof(std::uint32_t));
        for (const std::uint32_t x : state_)
            if (x < kLeastState) throw Error(ErrorCode::corrupt, "impossible state of a range code");
        next_ = bytes.data() + kLanes * sizeof(std::uint32_t);
        end_ = bytes.data() + bytes.size();
    }

    void decode(const std::uint8_t* context, std::size_t count, std::uint8_t* token) {
        std::array<std::uint32_t, kLanes> x = state_;
        const std::byte* next = next_;
        std::size_t k = 0;
        for (; k + kLanes <= count && end_ - next >= 2 * kLanes; k += kLanes)
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                token[k + lane] = step(x[lane], context[k + lane]);
                std::uint16_t word;
                std::memcpy(&word, next, 2);
                const bool low = x[lane] < kLeastState;
                x[lane] = low ? x[lane] << 16 | word : x[lane];
                next += low ? 2 : 0;
            }
        for (; k < count; ++k) {
            std::uint32_t& state = x[k % kLanes];
            token[k] = step(state, context[k]);
            if (state >= kLeastState) continue;
            if (end_ - next < 2) throw Error(ErrorCode::truncated, "range code ends early");
            std::uint16_t word;
            std::memcpy(&word, next, 2);
            state = state << 16 | word;
            next += 2;
        }
        state_ = x;
        next_ = next;
    }

    // 16 bits a state, left there by the encoder, then the bytes that were not read.
    void rest(std::vector<std::uint8_t>& raw, std::size_t& raw_bytes) const {
        raw.clear();
        for (const std::uint32_t x : state_) {
            if (x >= 2 * kLeastState)
                throw Error(ErrorCode::corrupt, "range code ends in an impossible state");
            raw.push_back(static_cast<std::uint8_t>(x));
            raw.push_back(static_cast<std::uint8_t>(x >> 8));
        }
        raw_bytes = static_cast<std::size_t>(end_ - next_);
        raw.resize(raw.size() + raw_bytes);
        if (raw_bytes > 0) std::memcpy(raw.data() + 2 * kLanes, next_, raw_bytes);
    }

  private:
    std::uint8_t step(std::uint32_t& x, std::size_t context) const {
        const std::uint32_t slot = x & (kFrequencySum - 1), inside = slot & (kBucketSize - 1);
        const std::size_t at = context * kTokens + (slot >> kBucketBits);
        const std::uint32_t e = entry_[at][inside >= cutoff_[at] ? 1 : 0];
        x = ((e >> 6) & (kFrequencySum - 1)) * (x >> kFrequencyBits) +
            ((inside + (e >> 18)) & (kFrequencySum - 1));
        return static_cast<std::uint8_t>(e & (kTokens - 1));
    }

    const std::uint8_t* cutoff_;
    const std::array<std::uint32_t, 2>* entry_;
    std::array<std::uint32_t, kLanes> state_;
    const std::byte *next_, *end_;
};

// Puts the tokens of a pass back in their places.
void place_tokens(int rows, int pass, RangeScratch& s) {
    for_pass(rows, pass, [&](std::size_t cell, std::size_t k) { s.token[cell] = s.pass_token[k]; });
}

template <int kLanes>
void decode_tokens(const RangeTables::Model& model, const RangeInput& in, int offset,
                   std::span<const std::byte> bytes, RangeScratch& s, std::size_t& raw_bytes) {
    TokenDecoder<kLanes> decoder(model, bytes);
    decoder.decode(s.pass_context.data(), pass_contexts(in, 0, offset, s), s.pass_token.data());
    place_tokens(in.rows, 0, s);
    sum_neighbours(in.rows, s);
    decoder.decode(s.pass_context.data(), pass_contexts(in, 1, offset, s), s.pass_token.data());
    place_tokens(in.rows, 1, s);
    decoder.rest(s.raw, raw_bytes);
}

// Indices from tokens and raw bits; all of s.raw must be used up but for zeros.
void make_indices(int lanes, std::size_t raw_bytes, RangeScratch& s, std::span<std::int32_t> index) {
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < index.size(); ++k) {
        index[k] = unzigzag(s.token[k]);
        bits += kRawBits[s.token[k]];
    }
    const std::uint64_t kept = 16 * static_cast<std::uint64_t>(lanes);
    if (raw_bytes != (bits <= kept ? 0 : (bits - kept + 7) / 8))
        throw Error(ErrorCode::corrupt, "range code has a wrong number of raw bits");
    BitReader reader(std::as_bytes(std::span<const std::uint8_t>(s.raw)));
    if (bits > 0)
        for (std::size_t k = 0; k < index.size(); ++k) {
            const int count = kRawBits[s.token[k]];
            if (count == 0) continue;
            reader.refill();
            const std::uint64_t raw = reader.take(count);
            index[k] = unzigzag(token_base(s.token[k]) + static_cast<std::uint32_t>(raw));
        }
    if (!reader.only_zeros_left()) throw Error(ErrorCode::corrupt, "range code has bits left over");
}

}  // namespace

double range_cost(const RangeTables::Model& model, const RangeInput& in, std::span<const std::int32_t> index,
                  RangeScratch& s) {
    prepare(in, s);
    make_tokens(index, s);
    sum_neighbours(in.rows, s);
    return static_cast<double>(token_cost(model, in, 0, s)) / 256;
}

void range_encode(const RangeTables::Model& model, const RangeInput& in, std::span<const std::int32_t> index,
                  RangeScratch& s, RangeStatistics* statistics, std::vector<std::byte>& out) {
    prepare(in, s);
    make_tokens(index, s);
    sum_neighbours(in.rows, s);
    const Choice choice = best_offset(model, in, s);
    const int log2_lanes = log2_lanes_for(choice.cost / 256), lanes = 1 << log2_lanes;

    // Tokens of frequency 0 are written as escapes. Neighbours saw them before: contexts do not change.
    std::vector<std::uint8_t> contexts, tokens;
    std::array<std::size_t, 2> counts{};
    for (const int pass : {0, 1}) {
        counts[static_cast<std::size_t>(pass)] = pass_contexts(in, pass, choice.offset, s);
        for_pass(in.rows, pass, [&](std::size_t cell, std::size_t k) {
            const std::size_t context = s.pass_context[k];
            if (statistics != nullptr) statistics->add(context, s.token[cell]);
            if (model.frequency[context][s.token[cell]] == 0) s.token[cell] = kEscape;
            contexts.push_back(s.pass_context[k]);
            tokens.push_back(s.token[cell]);
        });
        if (pass == 0) sum_neighbours(in.rows, s);  // escapes look different to neighbours
    }
    const std::vector<std::byte> raw = write_raw(index, model, s);

    std::array<std::uint32_t, kMostLanes> x{};
    const auto payload = [&](std::size_t k) {
        return k < raw.size() ? static_cast<std::uint32_t>(raw[k]) : 0u;
    };
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(lanes); ++lane)
        x[lane] = kLeastState + payload(2 * lane) + (payload(2 * lane + 1) << 8);
    s.words.clear();
    StateEncoder encoder(model, s.words);
    for (const std::size_t pass : {std::size_t{1}, std::size_t{0}}) {
        const std::size_t begin = pass == 0 ? 0 : counts[0];
        for (std::size_t k = counts[pass]; k-- > 0;)
            encoder.put(x[k % static_cast<std::size_t>(lanes)], contexts[begin + k], tokens[begin + k]);
    }
    std::reverse(s.words.begin(), s.words.end());
    out.push_back(static_cast<std::byte>(log2_lanes | (choice.offset - kLeastOffset) << 2));
    append(out, x.data(), static_cast<std::size_t>(lanes) * sizeof(std::uint32_t));
    append(out, s.words.data(), s.words.size() * sizeof(std::uint16_t));
    const std::size_t kept = 2 * static_cast<std::size_t>(lanes);
    if (raw.size() > kept) append(out, raw.data() + kept, raw.size() - kept);
}

void range_decode(const RangeTables::Model& model, const RangeInput& in, std::span<const std::byte> bytes,
                  RangeScratch& s, std::span<std::int32_t> index) {
    if (bytes.empty()) throw Error(ErrorCode::truncated, "range code is empty");
    const auto head = static_cast<unsigned>(bytes[0]);
    if (head >= 64) throw Error(ErrorCode::corrupt, "unknown form of a range code");
    const int offset = static_cast<int>(head >> 2) + kLeastOffset;
    prepare(in, s);
    std::size_t raw_bytes = 0;
    const std::span<const std::byte> code = bytes.subspan(1);
    switch (head & 3) {
        case 0:
            decode_tokens<1>(model, in, offset, code, s, raw_bytes);
            break;
        case 1:
            decode_tokens<2>(model, in, offset, code, s, raw_bytes);
            break;
        case 2:
            decode_tokens<4>(model, in, offset, code, s, raw_bytes);
            break;
        default:
            decode_tokens<8>(model, in, offset, code, s, raw_bytes);
            break;
    }
    make_indices(1 << (head & 3), raw_bytes, s, index);
}

}  // namespace carat
