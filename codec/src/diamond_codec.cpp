#include "carat/codec/diamond_codec.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "bytes.hpp"
#include "carat/codec/predict.hpp"
#include "carat/codec/quantize.hpp"
#include "gamma.hpp"
#include "kernels.hpp"
#include "range.hpp"
#include "update_kernels.hpp"

namespace carat {
namespace {

[[maybe_unused]] constexpr std::int32_t kGreatestRadius = 1 << 29;
constexpr std::size_t kMostBytesToTryGamma = 128;
constexpr std::size_t kGammaMayBeLonger = 110;  // percent of the range code

void resize(RefinedHeights& out, CodecScratch& s, int n) {
    const auto vertices = static_cast<std::size_t>(n * n),
               cells = static_cast<std::size_t>((n - 1) * (n - 1));
    out.n = n;
    out.v.resize(vertices);
    out.c.resize(cells);
    s.prediction.resize(cells);
    s.indices_c.resize(cells);
    s.indices_v.resize(static_cast<std::size_t>((n - 2) * (n - 2)));
}

bool all_zero(const std::vector<std::int32_t>& x) {
    return std::all_of(x.begin(), x.end(), [](std::int32_t v) { return v == 0; });
}

// --- one matrix of indices ---

// What predicts the C of a diamond, and the V of mode 1 (from P) and 2 (from C), as contexts see it.
RangeInput centres_input(const std::int32_t* vertices, int n, std::int32_t radius) {
    return {vertices, n, n - 1, radius};
}
RangeInput vertices_input(Mode mode, const std::int32_t* p, const RefinedHeights& out, std::int32_t radius) {
    if (mode == Mode::filtered) return {p, out.n, out.n - 2, radius};
    return {out.c.data(), out.n - 1, out.n - 2, radius};
}

// What the indices would cost, comparable between orders: range in 1/256 bit, gamma in bits.
std::uint64_t cost_of(const Coding& coding, const RangeInput& input, const std::vector<std::int32_t>& index,
                      CodecScratch& s) {
    if (coding.coder == CoderId::range)
        return range_cost(coding.tables->model(), index, input.rows, *s.range);
    return s.gamma_writer->cost(index, input.rows, input.m - 1, 2);
}

struct CentresChoice {
    Order order = Order::four;
    Activity activity = Activity::window;
    bool any = false;  // an index that is not zero
};

// Fills prediction and indices of C with the cheapest order.
CentresChoice choose_centres(const Coding& coding, const std::int32_t* vertices, const RefinedHeights& ref,
                             std::int32_t radius, CodecScratch& s) {
    RangeInput input = centres_input(vertices, ref.n, radius);
    const bool range = coding.coder == CoderId::range;
    CentresChoice choice{};
    assert((coding.orders & 0b111) != 0);
    const auto quantised = [&](Order o, std::vector<std::int32_t>& index) {
        kernel::predict(vertices, ref.n, o, s.prediction.data());
        return kernel::quantize(ref.c.data(), s.prediction.data(), index.size(), radius, index.data());
    };
    std::uint64_t best = 0;
    bool first = true;
    Order last = choice.order;
    const bool single = !range && std::has_single_bit(coding.orders & 0b111);
    if (range) range_prepare_cost(input, *s.range);
    for (const Order o : {Order::four, Order::six, Order::two}) {  // order 4 where all are as good
        if ((coding.orders >> static_cast<unsigned>(o) & 1) == 0) continue;
        s.trial.resize(ref.c.size());
        const bool nonzero = quantised(o, s.trial);
        last = o;
        const std::uint64_t cost = !nonzero || single ? 0 : cost_of(coding, input, s.trial, s);
        if (!first && cost >= best) continue;
        first = false;
        best = cost;
        choice.order = o;
        choice.any = nonzero;
        std::swap(s.trial, s.indices_c);
        if (!nonzero) break;
    }
    if (last != choice.order) kernel::predict(vertices, ref.n, choice.order, s.prediction.data());
    if (!range || !choice.any) return choice;
    input.activity = Activity::corners;
    range_prepare_cost(input, *s.range);
    if (cost_of(coding, input, s.indices_c, s) < best) choice.activity = Activity::corners;
    return choice;
}

// What predicts V inside: P, or in mode 2 also the C that `out` holds.
kernel::VertexBase vertex_base(Mode mode, Order order, const std::int32_t* p, const RefinedHeights& out,
                               CodecScratch& s) {
    if (mode == Mode::filtered) return {p, nullptr};
    kernel::predict(out.c.data(), out.n - 1, order, s.prediction.data());
    return {p, s.prediction.data()};
}

void encode_vertices(Mode mode, Order order, const std::int32_t* p, const RefinedHeights& ref,
                     std::int32_t radius, RefinedHeights& out, CodecScratch& s) {
    const kernel::VertexBase base = vertex_base(mode, order, p, out, s);
    kernel::quantize_vertices(ref.v.data(), base, ref.n, radius, s.indices_v.data());
    kernel::update_vertices(base, s.indices_v.data(), ref.n, 2 * radius + 1, out.v.data());
}

void decode_vertices(Mode mode, Order order, const std::int32_t* p, std::int32_t radius, RefinedHeights& out,
                     CodecScratch& s) {
    const kernel::VertexBase base = vertex_base(mode, order, p, out, s);
    kernel::update_vertices(base, s.indices_v.data(), out.n, 2 * radius + 1, out.v.data());
}

// --- gamma: one bit string for both matrices ---

struct GammaSize {
    int leaf_size;
    std::uint64_t bits;
};
GammaSize gamma_size(int n, bool has_v, CodecScratch& s) {
    const int side = n - 1;
    const auto cost = [&](int leaf) {
        return s.gamma_writer->cost(s.indices_c, side, side, leaf) +
               (has_v ? s.gamma_writer->cost(s.indices_v, n - 2, side, leaf) : 0);
    };
    const std::uint64_t two = cost(2), four = cost(4);
    return four < two ? GammaSize{4, four} : GammaSize{2, two};
}

std::span<const std::byte> gamma_blob(int n, bool has_v, int leaf_size, CodecScratch& s) {
    const int side = n - 1;
    s.gamma_writer->open();
    s.gamma_writer->add(s.indices_c, side, side, leaf_size);
    if (has_v) s.gamma_writer->add(s.indices_v, n - 2, side, leaf_size);
    return s.gamma_writer->finish();
}

void read_gamma_blob(const BlobInfo& info, std::span<const std::byte> blob, int n, CodecScratch& s) {
    const int side = n - 1;
    s.gamma->open(blob);
    s.gamma->read(side, side, info.leaf_size, s.indices_c);
    if (info.mode != Mode::interpolating) s.gamma->read(n - 2, side, info.leaf_size, s.indices_v);
    s.gamma->finish();
}

// --- range: in modes 1 and 2 the length of the first matrix stands before it; length 0: all zero ---

void range_matrix(const Coding& coding, const RangeInput& input, const std::vector<std::int32_t>& index,
                  CodecScratch& s, std::vector<std::byte>& out) {
    if (!all_zero(index)) range_encode(coding.tables->model(), input, index, *s.range, s.statistics, out);
}

std::span<const std::byte> range_blob(const Coding& coding, Mode mode, const std::int32_t* p,
                                      std::int32_t radius, Activity activity, const RefinedHeights& out,
                                      CodecScratch& s) {
    std::vector<std::byte>&first = s.range->matrix, &blob = s.range->blob;
    first.clear();
    blob.clear();
    RangeInput c = centres_input(mode == Mode::paper ? p : out.v.data(), out.n, radius);
    c.activity = activity;
    if (mode == Mode::interpolating) {
        range_matrix(coding, c, s.indices_c, s, blob);
        return blob;
    }
    const RangeInput v = vertices_input(mode, p, out, radius);
    const bool v_first = mode == Mode::filtered;
    range_matrix(coding, v_first ? v : c, v_first ? s.indices_v : s.indices_c, s, first);
    put_varint(blob, first.size());
    blob.insert(blob.end(), first.begin(), first.end());
    range_matrix(coding, v_first ? c : v, v_first ? s.indices_c : s.indices_v, s, blob);
    return blob;
}

void read_range_matrix(const Coding& coding, const RangeInput& input, std::span<const std::byte> bytes,
                       std::vector<std::int32_t>& index, CodecScratch& s) {
    if (bytes.empty())
        std::fill(index.begin(), index.end(), 0);
    else
        range_decode(coding.tables->model(), input, bytes, *s.range, index);
}

// The bytes of the first and of the second matrix.
std::array<std::span<const std::byte>, 2> range_parts(Mode mode, std::span<const std::byte> blob) {
    if (mode == Mode::interpolating || blob.empty()) return {blob, {}};
    ByteParser in(blob, "range code");
    const std::size_t first = in.varint();
    const std::span<const std::byte> bytes = in.take(first);
    return {bytes, in.take(in.left())};
}

}  // namespace

CodecScratch::CodecScratch()
    : range(std::make_unique<RangeScratch>()),
      gamma(std::make_unique<GammaReader>()),
      gamma_writer(std::make_unique<GammaWriter>()) {}
CodecScratch::~CodecScratch() = default;
CodecScratch::CodecScratch(CodecScratch&&) noexcept = default;
CodecScratch& CodecScratch::operator=(CodecScratch&&) noexcept = default;

std::uint8_t BlobInfo::to_byte() const {
    return static_cast<std::uint8_t>(static_cast<int>(mode) | (leaf_size == 4 ? 4 : 0) |
                                     static_cast<int>(order) << 3 | (gamma ? 32 : 0));
}

BlobInfo BlobInfo::from_byte(std::uint8_t byte) {
    if ((byte & 3) > 2 || (byte >> 3 & 3) > 2 || byte >> 6 != 0)
        throw Error(ErrorCode::corrupt, "unknown coding mode of a diamond");
    return {static_cast<Mode>(byte & 3), (byte & 4) != 0 ? 4 : 2, (byte & 32) != 0,
            static_cast<Order>(byte >> 3 & 3)};
}

EncodedResiduals encode_residuals(const Coding& coding, Mode mode, std::span<const std::int32_t> p,
                                  const RefinedHeights& ref, std::int32_t radius, RefinedHeights& out,
                                  CodecScratch& s) {
    const int n = ref.n;
    assert(p.size() == static_cast<std::size_t>(n * n) && ref.v.size() == p.size());
    assert(radius >= 0 && radius <= kGreatestRadius);
    resize(out, s, n);
    std::copy(p.begin(), p.end(), out.v.begin());
    EncodedResiduals e;
    e.info.mode = mode;
    if (mode == Mode::filtered) encode_vertices(mode, e.info.order, p.data(), ref, radius, out, s);
    const std::int32_t* predicting = mode == Mode::paper ? p.data() : out.v.data();
    const CentresChoice choice = choose_centres(coding, predicting, ref, radius, s);
    e.info.order = choice.order;
    kernel::reconstruct(s.prediction.data(), s.indices_c.data(), out.c.size(), 2 * radius + 1, out.c.data());
    if (mode == Mode::paper) encode_vertices(mode, e.info.order, p.data(), ref, radius, out, s);
    const bool has_v = mode != Mode::interpolating;
    if (!choice.any && (!has_v || all_zero(s.indices_v))) return e;
    const auto keep = [&e](std::span<const std::byte> blob) { e.blob.assign(blob.begin(), blob.end()); };
    const bool range = coding.coder == CoderId::range;
    std::span<const std::byte> code;
    if (range) {
        code = range_blob(coding, mode, p.data(), radius, choice.activity, out, s);
        if (code.size() > kMostBytesToTryGamma) {
            keep(code);
            return e;
        }
    }
    // A sparse diamond is decoded several times as fast by gamma, and is often no longer.
    const GammaSize gamma = gamma_size(n, has_v, s);
    if (range && (gamma.bits + 7) / 8 > code.size() * kGammaMayBeLonger / 100) {
        keep(code);
        return e;
    }
    e.info.gamma = range;
    e.info.leaf_size = gamma.leaf_size;
    keep(gamma_blob(n, has_v, gamma.leaf_size, s));
    return e;
}

void decode_residuals(const Coding& coding, const BlobInfo& info, std::span<const std::byte> blob,
                      std::span<const std::int32_t> p, int n, std::int32_t radius, RefinedHeights& out,
                      CodecScratch& s) {
    assert(p.size() == static_cast<std::size_t>(n * n) && radius >= 0 && radius <= kGreatestRadius);
    assert(info.mode == Mode::interpolating || p.data() != out.v.data());
    resize(out, s, n);
    std::copy(p.begin(), p.end(), out.v.begin());
    const bool gamma = (coding.coder == CoderId::gamma || info.gamma) && !blob.empty(),
               v_first = info.mode == Mode::filtered;
    if (gamma && info.mode == Mode::interpolating) {
        kernel::predict(p.data(), n, info.order, out.c.data());
        s.gamma->open(blob);
        s.gamma->add(n - 1, n - 1, info.leaf_size, 2 * radius + 1, out.c);
        return s.gamma->finish();
    }
    if (gamma) read_gamma_blob(info, blob, n, s);
    const auto parts = range_parts(info.mode, gamma ? std::span<const std::byte>{} : blob);
    const auto vertices = [&](std::size_t part) {
        if (!gamma)
            read_range_matrix(coding, vertices_input(info.mode, p.data(), out, radius), parts[part],
                              s.indices_v, s);
        decode_vertices(info.mode, info.order, p.data(), radius, out, s);
    };
    if (v_first) vertices(0);
    const std::int32_t* predicting = info.mode == Mode::paper ? p.data() : out.v.data();
    if (blob.empty() && info.mode == Mode::interpolating) {
        kernel::predict(predicting, n, info.order, out.c.data());
        return;
    }
    kernel::predict(predicting, n, info.order, s.prediction.data());
    if (!gamma)
        read_range_matrix(coding, centres_input(predicting, n, radius), parts[v_first ? 1 : 0], s.indices_c,
                          s);
    kernel::reconstruct(s.prediction.data(), s.indices_c.data(), out.c.size(), 2 * radius + 1, out.c.data());
    if (info.mode == Mode::paper) vertices(1);
}

void filter_vertices(const RefinedHeights& ref, std::span<std::int32_t> p) {
    const int n = ref.n;
    assert(p.size() == static_cast<std::size_t>(n * n) && ref.v.size() == p.size());
    kernel::predict(ref.c.data(), n - 1, Order::four, p.data());
    kernel::filter_vertices(ref.v.data(), p.data(), n, p.data());
    const auto row = static_cast<std::size_t>(n), last = row * (row - 1);
    std::copy_n(ref.v.data(), row, p.data());
    std::copy_n(ref.v.data() + last, row, p.data() + last);
    for (std::size_t at = row; at < last; at += row) {
        p[at] = ref.v[at];
        p[at + row - 1] = ref.v[at + row - 1];
    }
}

}  // namespace carat
