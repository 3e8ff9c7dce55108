#include "range.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "bits.hpp"
#include "range_kernels.hpp"

namespace carat {
namespace {

constexpr int kStateBits = 16;  // states lie in [2^16, 2^32); 16 bits are read at a time
constexpr std::uint32_t kLeastState = 1u << kStateBits;
constexpr std::uint32_t kNeighbourWeight = 48;         // steps of activity for each index unit of a neighbour
constexpr int kLeastOffset = -8, kGreatestOffset = 7;  // of contexts, in quarter octaves
constexpr int kCostRows = 2;                           // every how many rows are looked at to compare codes

constexpr auto kRawBits = [] {
    std::array<std::uint8_t, kTokens> t{};
    for (int k = 0; k < kTokens; ++k) t[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(raw_bits(k));
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

// A pass of a matrix: rows of `pitch` elements, the last of which may be a gap.
struct Passes {
    explicit Passes(int side) : rows(side), pitch(static_cast<std::size_t>(side + 1) / 2) {}
    std::size_t size() const { return static_cast<std::size_t>(rows) * pitch; }
    std::size_t width(int row, int pass) const {
        return (static_cast<std::size_t>(rows) + 1 - static_cast<std::size_t>((row + pass) & 1)) / 2;
    }

    // Moves elements together, or apart again with 0 in the gaps; returns how many there are.
    std::size_t close_gaps(int pass, std::uint8_t* x) const {
        if (rows % 2 == 0) return size();
        std::size_t to = 0;
        for (int i = 0; i < rows; ++i) {
            std::memmove(x + to, x + static_cast<std::size_t>(i) * pitch, width(i, pass));
            to += width(i, pass);
        }
        return to;
    }
    void open_gaps(int pass, std::size_t count, std::uint8_t* x) const {
        if (rows % 2 == 0) return;
        for (int i = rows; i-- > 0;) {
            const std::size_t w = width(i, pass);
            count -= w;
            std::memmove(x + static_cast<std::size_t>(i) * pitch, x + count, w);
            if (w < pitch) x[static_cast<std::size_t>(i) * pitch + w] = 0;
        }
    }

    int rows;
    std::size_t pitch;
};

void prepare(const RangeInput& in, RangeScratch& s) {
    const Passes passes(in.rows);
    const ActivityScale scale(in.radius);
    s.activity.resize(square(in.m - 1));
    kernel::cell_activity(in.known, in.m, scale, in.activity, s.activity_scratch, s.activity.data());
    for (auto* both : {&s.context, &s.token})
        for (auto& x : *both) x.resize(passes.size());
    for (auto& x : s.pass_activity) x.resize(passes.size());
    s.near.resize(passes.size());
    s.cells.resize(square(in.rows) + 32);
    s.big.resize(square(in.rows));
    // Of a matrix smaller than that of the cells, cell (i, j) stands for (i, j).
    kernel::split_passes(s.activity.data(), static_cast<std::size_t>(in.m - 1), in.rows, 24 * scale.step,
                         s.pass_activity[0].data(), s.pass_activity[1].data());
}

// Contexts of a pass into s.context without gaps; returns how many. The second pass reads the tokens of the
// first, with 0 in their gaps.
std::size_t pass_contexts(const RangeInput& in, int pass, int offset, RangeScratch& s) {
    const ActivityScale scale(in.radius);
    const Passes passes(in.rows);
    const auto p = static_cast<std::size_t>(pass);
    if (pass == 1) kernel::neighbour_magnitudes(s.token[0].data(), in.rows, s.magnitude, s.near.data());
    kernel::contexts(s.pass_activity[p].data(), pass == 0 ? nullptr : s.near.data(),
                     kNeighbourWeight * scale.step, passes.size(), context_bias(scale, offset),
                     static_cast<std::uint8_t>(pass * kPassContexts), s.context[p].data());
    return passes.close_gaps(pass, s.context[p].data());
}

// Size of the tokens and raw bits of a part of the rows, 1/256 bit; tokens with gaps.
std::uint64_t cost_of(const RangeTables::Model& model, const RangeInput& in, int offset, RangeScratch& s) {
    const std::uint16_t* cost = model.encoder().cost.data();
    const ActivityScale scale(in.radius);
    const Passes passes(in.rows);
    std::uint64_t sum = 0;
    for (const int pass : {0, 1}) {
        const auto p = static_cast<std::size_t>(pass);
        for (int i = 0; i < in.rows; i += kCostRows) {
            const std::size_t at = static_cast<std::size_t>(i) * passes.pitch, width = passes.width(i, pass);
            std::uint8_t* context = s.context[p].data() + at;
            kernel::contexts(s.pass_activity[p].data() + at, pass == 0 ? nullptr : s.near.data() + at,
                             kNeighbourWeight * scale.step, width, context_bias(scale, offset),
                             static_cast<std::uint8_t>(pass * kPassContexts), context);
            const std::uint8_t* token = s.token[p].data() + at;
            for (std::size_t k = 0; k < width; ++k) sum += cost[std::size_t{context[k]} * kTokens + token[k]];
        }
    }
    return sum;
}

struct Choice {
    int offset;
    std::uint64_t cost;
};

// The offset with the least cost near 0: costs have one valley.
Choice best_offset(const RangeTables::Model& model, const RangeInput& in, RangeScratch& s) {
    kernel::neighbour_magnitudes(s.token[0].data(), in.rows, s.magnitude, s.near.data());
    Choice best{0, cost_of(model, in, 0, s)};
    for (const int direction : {1, -1}) {
        const int from = best.offset;
        for (int o = from + direction; o >= kLeastOffset && o <= kGreatestOffset; o += direction) {
            const std::uint64_t cost = cost_of(model, in, o, s);
            if (cost >= best.cost) break;
            best = {o, cost};
        }
        if (best.offset != 0) break;
    }
    return best;
}

// A state costs about half a byte, and two more if there are no raw bits to fill it with: few for short
// codes.
int log2_states_for(std::uint64_t bits, std::uint64_t raw) {
    int k = bits < 150 ? 0 : bits < 300 ? 1 : bits < 700 ? 2 : bits < 2500 ? 3 : bits < 40000 ? 4 : 5;
    while (k > 0 && (std::uint64_t{kStateBits} << k) > raw) --k;
    return k;
}

// Signs of the tokens that are not 0, then the raw bits of their magnitudes, in order of cells.
std::span<const std::byte> write_raw(std::span<const std::int32_t> index, const std::uint8_t* token,
                                     BitWriter& out, std::uint64_t& count) {
    out.clear();
    std::uint64_t word = 0;
    int filled = 0;
    count = 0;
    const auto put = [&](std::uint64_t value, int bits) {  // bits <= 32
        word |= value << filled;
        filled += bits;
        if (filled <= 24) return;
        out.put(word, filled);
        count += static_cast<std::uint64_t>(filled);
        word = 0;
        filled = 0;
    };
    for (std::size_t k = 0; k < index.size(); ++k) put(index[k] < 0 ? 1 : 0, token[k] != 0 ? 1 : 0);
    for (std::size_t k = 0; k < index.size(); ++k) {
        const int n = kRawBits[token[k]];
        if (n != 0) put(magnitude_of(index[k]) - token_base(token[k]), n);
    }
    out.put(word, filled);
    count += static_cast<std::uint64_t>(filled);
    return out.finished();
}

// Encodes backwards what a decoder reads forwards: words are written from the end of `words` on, which must
// have room for one a token.
class StateEncoder {
  public:
    StateEncoder(const RangeTables::Model& model, std::vector<std::uint16_t>& words)
        : frequency_(model.frequency[0].data()),
          begin_(model.encoder().begin.data()),
          slot_(model.encoder().slot.data()),
          next_(words.data() + words.size()) {}

    void put(std::uint32_t& x, std::size_t context, std::size_t token) {
        const std::size_t at = context * kTokens + token;
        const std::uint32_t f = frequency_[at];
        const bool full = x >= f << 20;  // f < 2^12
        next_[-1] = static_cast<std::uint16_t>(x);
        next_ -= full ? 1 : 0;
        x = full ? x >> 16 : x;
        const std::uint32_t quotient = x / f, number = x - quotient * f;
        x = (quotient << kFrequencyBits) | slot_[context * kFrequencySum + begin_[at] + number];
    }
    const std::uint16_t* first() const { return next_; }

  private:
    const std::uint16_t *frequency_, *begin_, *slot_;
    std::uint16_t* next_;
};

void append(std::vector<std::byte>& out, const void* data, std::size_t bytes) {
    const auto* p = static_cast<const std::byte*>(data);
    out.insert(out.end(), p, p + bytes);
}

// Contexts and tokens of both passes in coding order; tokens of frequency 0 become escapes, which look
// different to neighbours. Returns how many there are of each pass.
std::array<std::size_t, 2> final_tokens(const RangeTables::Model& model, const RangeInput& in, int offset,
                                        RangeScratch& s, RangeStatistics* statistics) {
    const Passes passes(in.rows);
    std::array<std::size_t, 2> counts{};
    for (const std::size_t p : {std::size_t{0}, std::size_t{1}}) {
        const int pass = static_cast<int>(p);
        counts[p] = pass_contexts(in, pass, offset, s);
        std::uint8_t* token = s.token[p].data();
        passes.close_gaps(pass, token);
        if (statistics != nullptr)
            for (std::size_t k = 0; k < counts[p]; ++k) statistics->add(s.context[p][k], token[k]);
        for (std::size_t k = 0; k < counts[p]; ++k) {
            const std::size_t context = s.context[p][k];
            if (model.frequency[context][token[k]] == 0) token[k] = kEscape;
        }
        if (pass == 0) passes.open_gaps(0, counts[0], token);
    }
    return counts;
}

// Four bits k, then 16 + k bits: the state is 2^(16+k) and those.
std::span<const std::byte> write_states(std::span<const std::uint32_t> states, BitWriter& bits) {
    bits.clear();
    for (const std::uint32_t x : states) {
        const int k = static_cast<int>(std::bit_width(x)) - 1 - kStateBits;
        bits.put(static_cast<std::uint64_t>(k), 4);
        bits.put(x ^ 1u << (kStateBits + k), kStateBits + k);
    }
    return bits.finished();
}

// Reads what write_states wrote; the run's words begin behind it.
void read_states(std::span<const std::byte> bytes, int states, StateRun& run) {
    BitReader bits(bytes);
    std::size_t used = 0;
    for (int lane = 0; lane < states; ++lane) {
        bits.refill();
        const int k = static_cast<int>(bits.take(4));
        run.x[static_cast<std::size_t>(lane)] =
            1u << (kStateBits + k) | static_cast<std::uint32_t>(bits.take(kStateBits + k));
        used += static_cast<std::size_t>(4 + kStateBits + k);
    }
    if (bits.overrun()) throw Error(ErrorCode::truncated, "range code ends inside its states");
    if (bits.take(static_cast<int>(-used % 8)) != 0)
        throw Error(ErrorCode::corrupt, "range code has bits left over after its states");
    run.next = bytes.data() + (used + 7) / 8;
    run.end = bytes.data() + bytes.size();
}

// Into s.raw: 16 bits a state, left there by the encoder, then the bytes that were not read; returns how many
// of these.
std::size_t take_raw(const StateRun& run, int states, RangeScratch& s) {
    const auto raw_bytes = static_cast<std::size_t>(run.end - run.next),
               kept = 2 * static_cast<std::size_t>(states);
    s.raw.resize(kept + raw_bytes + 8);
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(states); ++lane) {
        if (run.x[lane] >= 2 * kLeastState)
            throw Error(ErrorCode::corrupt, "range code ends in an impossible state");
        const auto payload = static_cast<std::uint16_t>(run.x[lane]);
        std::memcpy(s.raw.data() + 2 * lane, &payload, 2);
    }
    if (raw_bytes > 0) std::memcpy(s.raw.data() + kept, run.next, raw_bytes);
    std::memset(s.raw.data() + kept + raw_bytes, 0, 8);
    return raw_bytes;
}

// Indices from s.cells and s.raw; all of s.raw must be used up but for zeros.
void make_indices(int states, std::size_t raw_bytes, RangeScratch& s, std::span<std::int32_t> index) {
    const std::uint8_t* token = s.cells.data();
    const kernel::TokenCensus census = kernel::take_census(token, index.size(), s.big.data());
    std::uint64_t bits = census.nonzero;
    for (std::size_t k = 0; k < census.big; ++k) bits += kRawBits[token[s.big[k]]];
    const std::uint64_t kept = static_cast<std::uint64_t>(kStateBits) * static_cast<std::uint64_t>(states);
    if (raw_bytes != (bits <= kept ? 0 : (bits - kept + 7) / 8))
        throw Error(ErrorCode::corrupt, "range code has a wrong number of raw bits");
    kernel::apply_signs(token, index.size(), s.raw.data(), index.data());
    std::uint64_t at = census.nonzero;
    for (std::size_t k = 0; k < census.big; ++k) {
        const std::size_t cell = s.big[k];
        const int n = kRawBits[token[cell]];
        std::uint64_t word = 0;
        std::memcpy(&word, s.raw.data() + at / 8, 8);
        const std::uint64_t low = word >> (at % 8) & ((std::uint64_t{1} << n) - 1);
        index[cell] =
            with_sign(token_base(token[cell]) + static_cast<std::uint32_t>(low), index[cell] < 0 ? 1 : 0);
        at += static_cast<std::uint64_t>(n);
    }
    unsigned left = (at % 8 == 0 ? 0u : unsigned{s.raw[at / 8]} >> (at % 8));
    for (std::uint64_t byte = (at + 7) / 8; byte < s.raw.size(); ++byte) left |= s.raw[byte];
    if (left != 0) throw Error(ErrorCode::corrupt, "range code has bits left over");
}

}  // namespace

void range_prepare_cost(const RangeInput& in, RangeScratch& s) {
    assert(in.rows == in.m - 1);
    const ActivityScale scale(in.radius);
    s.activity.resize(square(in.rows));
    s.cost_context.resize(square(in.rows));
    kernel::cell_activity(in.known, in.m, scale, in.activity, s.activity_scratch, s.activity.data());
    for (int i = 0; i < in.rows; i += kCostRows) {
        const std::size_t at = static_cast<std::size_t>(i) * static_cast<std::size_t>(in.rows);
        kernel::contexts(s.activity.data() + at, nullptr, 0, static_cast<std::size_t>(in.rows),
                         context_bias(scale, 0), 0, s.cost_context.data() + at);
    }
}

std::uint64_t range_cost(const RangeTables::Model& model, std::span<const std::int32_t> index, int rows,
                         const RangeScratch& s) {
    const std::uint16_t* cost = model.encoder().cost.data();
    std::uint64_t sum = 0;
    for (int i = 0; i < rows; i += kCostRows) {
        const std::size_t at = static_cast<std::size_t>(i) * static_cast<std::size_t>(rows);
        for (std::size_t k = at; k < at + static_cast<std::size_t>(rows); ++k)
            sum += cost[std::size_t{s.cost_context[k]} * kTokens +
                        static_cast<std::size_t>(token_of(magnitude_of(index[k])))];
    }
    return kCostRows * sum;
}

void range_encode(const RangeTables::Model& model, const RangeInput& in, std::span<const std::int32_t> index,
                  RangeScratch& s, RangeStatistics* statistics, std::vector<std::byte>& out) {
    prepare(in, s);
    kernel::make_tokens(index.data(), index.size(), s.cells.data());
    kernel::split_passes(s.cells.data(), static_cast<std::size_t>(in.rows), in.rows, s.token[0].data(),
                         s.token[1].data());
    const Choice choice = best_offset(model, in, s);
    const auto counts = final_tokens(model, in, choice.offset, s, statistics);

    const Passes passes(in.rows);
    passes.open_gaps(1, counts[1], s.token[1].data());
    kernel::merge_passes(s.token[0].data(), s.token[1].data(), in.rows, s.cells.data());
    std::uint64_t raw_bits = 0;
    const std::span<const std::byte> raw = write_raw(index, s.cells.data(), s.raw_bits, raw_bits);
    for (const int pass : {0, 1}) passes.close_gaps(pass, s.token[static_cast<std::size_t>(pass)].data());

    const int log2_states = log2_states_for(kCostRows * choice.cost / 256, raw_bits);
    const auto states = std::size_t{1} << log2_states;
    std::array<std::uint32_t, kMostStates> x{};
    const auto payload = [&](std::size_t k) {
        return k < raw.size() ? static_cast<std::uint32_t>(raw[k]) : 0u;
    };
    for (std::size_t lane = 0; lane < states; ++lane)
        x[lane] = kLeastState + payload(2 * lane) + (payload(2 * lane + 1) << 8);
    s.words.resize(counts[0] + counts[1] + 1);
    StateEncoder encoder(model, s.words);
    for (const std::size_t p : {std::size_t{1}, std::size_t{0}})
        for (std::size_t k = counts[p]; k-- > 0;)
            encoder.put(x[k & (states - 1)], s.context[p][k], s.token[p][k]);

    out.push_back(static_cast<std::byte>(log2_states | (choice.offset - kLeastOffset) << 3 |
                                         static_cast<int>(in.activity) << 7));
    const std::span<const std::byte> first = write_states({x.data(), states}, s.state_bits);
    append(out, first.data(), first.size());
    append(
        out, encoder.first(),
        static_cast<std::size_t>(s.words.data() + s.words.size() - encoder.first()) * sizeof(std::uint16_t));
    if (raw.size() > 2 * states) append(out, raw.data() + 2 * states, raw.size() - 2 * states);
}

void range_decode(const RangeTables::Model& model, const RangeInput& input, std::span<const std::byte> bytes,
                  RangeScratch& s, std::span<std::int32_t> index) {
    if (bytes.empty()) throw Error(ErrorCode::truncated, "range code is empty");
    const auto head = static_cast<unsigned>(bytes[0]);
    if ((head & 7) > kMostLog2States) throw Error(ErrorCode::corrupt, "unknown form of a range code");
    const int states = 1 << (head & 7), offset = static_cast<int>(head >> 3 & 15) + kLeastOffset;
    RangeInput in = input;
    in.activity = static_cast<Activity>(head >> 7);
    StateRun run;
    s.code.resize(bytes.size() - 1 + kStatePadding);
    std::copy(bytes.begin() + 1, bytes.end(), s.code.begin());
    std::fill(s.code.end() - static_cast<std::ptrdiff_t>(kStatePadding), s.code.end(), std::byte{0});
    read_states(std::span(s.code).first(bytes.size() - 1), states, run);
    prepare(in, s);
    const Passes passes(in.rows);
    for (const std::size_t p : {std::size_t{0}, std::size_t{1}}) {
        const int pass = static_cast<int>(p);
        const std::size_t count = pass_contexts(in, pass, offset, s);
        if (!kernel::decode_tokens(model.buckets, states, run, s.context[p].data(), count, s.token[p].data()))
            throw Error(ErrorCode::truncated, "range code ends early");
        passes.open_gaps(pass, count, s.token[p].data());
    }
    const std::size_t raw_bytes = take_raw(run, states, s);
    kernel::merge_passes(s.token[0].data(), s.token[1].data(), in.rows, s.cells.data());
    make_indices(states, raw_bytes, s, index);
}

}  // namespace carat
