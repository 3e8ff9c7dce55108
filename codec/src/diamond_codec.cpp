#include "carat/codec/diamond_codec.hpp"

#include <algorithm>
#include <cassert>

#include "carat/codec/predict.hpp"
#include "carat/codec/quantize.hpp"
#include "gamma.hpp"

namespace carat {
namespace {

// Visits interior vertices: f(index in n x n, index in (n-2) x (n-2)).
template <class F>
void for_interior(int n, F f) {
    std::size_t k = 0;
    for (int i = 1; i < n - 1; ++i)
        for (int j = 1; j < n - 1; ++j) f(static_cast<std::size_t>(i * n + j), k++);
}

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

// One value: quantises target - prediction, returns the index and leaves the reconstruction in `value`.
std::int32_t code_value(std::int32_t target, std::int32_t prediction, std::int32_t radius,
                        std::int32_t& value) {
    const std::int32_t index = quantize(wrapping_sub(target, prediction), radius);
    value = wrapping_add(prediction, dequantize(index, radius));
    return index;
}

// 2P - pred(C), what mode 2 predicts for V; modulo 2^32.
std::int32_t paper_vertex(std::int32_t p, std::int32_t predicted) {
    return wrapping_sub(wrapping_mul(2, p), predicted);
}

void encode_centres(const std::int32_t* vertices, const RefinedHeights& ref, std::int32_t radius,
                    RefinedHeights& out, CodecScratch& s) {
    predict_centres(vertices, ref.n, s.prediction.data());
    for (std::size_t k = 0; k < out.c.size(); ++k)
        s.indices_c[k] = code_value(ref.c[k], s.prediction[k], radius, out.c[k]);
}

void decode_centres(const std::int32_t* vertices, std::int32_t radius, RefinedHeights& out, CodecScratch& s) {
    predict_centres(vertices, out.n, s.prediction.data());
    for (std::size_t k = 0; k < out.c.size(); ++k)
        out.c[k] = wrapping_add(s.prediction[k], dequantize(s.indices_c[k], radius));
}

bool all_zero(const std::vector<std::int32_t>& x) {
    return std::all_of(x.begin(), x.end(), [](std::int32_t v) { return v == 0; });
}

EncodedResiduals encode_indices(Mode mode, int n, const CodecScratch& s) {
    EncodedResiduals e;
    e.info.mode = mode;
    const bool has_v = mode != Mode::interpolating;
    if (all_zero(s.indices_c) && (!has_v || all_zero(s.indices_v))) return e;
    const int side = n - 1;
    const auto cost = [&](int leaf) {
        return gamma_cost(s.indices_c, side, side, leaf) +
               (has_v ? gamma_cost(s.indices_v, n - 2, side, leaf) : 0);
    };
    e.info.leaf_size = cost(4) < cost(2) ? 4 : 2;
    BitWriter bits;
    gamma_encode(s.indices_c, side, side, e.info.leaf_size, bits);
    if (has_v) gamma_encode(s.indices_v, n - 2, side, e.info.leaf_size, bits);
    e.blob = bits.finish();
    return e;
}

void decode_indices(const BlobInfo& info, std::span<const std::byte> blob, int n, CodecScratch& s) {
    const bool has_v = info.mode != Mode::interpolating;
    if (blob.empty()) {
        std::fill(s.indices_c.begin(), s.indices_c.end(), 0);
        std::fill(s.indices_v.begin(), s.indices_v.end(), 0);
        return;
    }
    const int side = n - 1;
    BitReader bits(blob);
    gamma_decode(bits, side, side, info.leaf_size, s.indices_c);
    if (has_v) gamma_decode(bits, n - 2, side, info.leaf_size, s.indices_v);
    bits.finish();
}

}  // namespace

std::uint8_t BlobInfo::to_byte() const {
    return static_cast<std::uint8_t>(static_cast<int>(mode) | (leaf_size == 4 ? 4 : 0));
}

BlobInfo BlobInfo::from_byte(std::uint8_t byte) {
    if ((byte & 3) > 2 || byte > 7) throw Error(ErrorCode::corrupt, "unknown coding mode of a diamond");
    return {static_cast<Mode>(byte & 3), (byte & 4) != 0 ? 4 : 2};
}

EncodedResiduals encode_residuals(Mode mode, std::span<const std::int32_t> p, const RefinedHeights& ref,
                                  std::int32_t radius, RefinedHeights& out, CodecScratch& s) {
    const int n = ref.n;
    assert(p.size() == static_cast<std::size_t>(n * n) && ref.v.size() == p.size());
    resize(out, s, n);
    std::copy(p.begin(), p.end(), out.v.begin());
    if (mode == Mode::filtered)
        for_interior(n, [&](std::size_t at, std::size_t k) {
            s.indices_v[k] = code_value(ref.v[at], p[at], radius, out.v[at]);
        });
    encode_centres(out.v.data(), ref, radius, out, s);
    if (mode == Mode::paper) {
        predict_centres(out.c.data(), n - 1, s.prediction.data());
        for_interior(n, [&](std::size_t at, std::size_t k) {
            s.indices_v[k] = code_value(ref.v[at], paper_vertex(p[at], s.prediction[k]), radius, out.v[at]);
        });
    }
    return encode_indices(mode, n, s);
}

void decode_residuals(const BlobInfo& info, std::span<const std::byte> blob, std::span<const std::int32_t> p,
                      int n, std::int32_t radius, RefinedHeights& out, CodecScratch& s) {
    assert(p.size() == static_cast<std::size_t>(n * n));
    resize(out, s, n);
    decode_indices(info, blob, n, s);
    std::copy(p.begin(), p.end(), out.v.begin());
    if (info.mode == Mode::filtered)
        for_interior(n, [&](std::size_t at, std::size_t k) {
            out.v[at] = wrapping_add(p[at], dequantize(s.indices_v[k], radius));
        });
    decode_centres(out.v.data(), radius, out, s);
    if (info.mode == Mode::paper) {
        predict_centres(out.c.data(), n - 1, s.prediction.data());
        for_interior(n, [&](std::size_t at, std::size_t k) {
            out.v[at] =
                wrapping_add(paper_vertex(p[at], s.prediction[k]), dequantize(s.indices_v[k], radius));
        });
    }
}

void filter_vertices(const RefinedHeights& ref, std::span<std::int32_t> p) {
    const int n = ref.n;
    std::copy(ref.v.begin(), ref.v.end(), p.begin());
    std::vector<std::int32_t> predicted(static_cast<std::size_t>((n - 2) * (n - 2)));
    predict_centres(ref.c.data(), n - 1, predicted.data());
    for_interior(n, [&](std::size_t at, std::size_t k) {
        const std::int64_t mean = (std::int64_t{ref.v[at]} + predicted[k] + 1) >> 1;
        p[at] = static_cast<std::int32_t>(std::clamp<std::int64_t>(mean, -kGreatestHeight, kGreatestHeight));
    });
}

}  // namespace carat
