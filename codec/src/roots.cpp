#include "roots.hpp"

#include <algorithm>
#include <unordered_map>

#include "bits.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/codec/writer.hpp"
#include "carat/globe/diamond.hpp"
#include "gamma_code.hpp"

namespace carat {
namespace {

std::int32_t predict(const std::vector<std::int32_t>& k, int n, int i, int j) {
    const auto at = [&](int r, int c) { return k[static_cast<std::size_t>(r * n + c)]; };
    if (i == 0 && j == 0) return 0;
    if (i == 0) return at(0, j - 1);
    if (j == 0) return at(i - 1, 0);
    const std::int32_t w = at(i, j - 1), north = at(i - 1, j), m = at(i - 1, j - 1);
    if (m >= std::max(w, north)) return std::min(w, north);
    if (m <= std::min(w, north)) return std::max(w, north);
    return wrapping_sub(wrapping_add(w, north), m);
}

// Visits every point in coding order; code(face, position, prediction) gives the index of a point met first.
template <class Code>
RootHeights visit_roots(int n, Code code) {
    RootHeights k;
    std::unordered_map<LatticePoint, std::int32_t, LatticePointHash> shared;
    for (int face = 0; face < kFaces; ++face) {
        auto& grid = k[static_cast<std::size_t>(face)];
        grid.resize(static_cast<std::size_t>(n * n));
        const HalfFrame frame = half_frame({root_diamond(face), 0}, n - 1);
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                const auto position = static_cast<std::size_t>(i * n + j);
                const LatticePoint p = frame.vertex(i, j);
                if (face_of(p) != face) {
                    grid[position] = shared.at(p);
                    continue;
                }
                grid[position] = code(face, position, predict(grid, n, i, j));
                if (i == 0 || j == 0 || i == n - 1 || j == n - 1) shared[p] = grid[position];
            }
    }
    return k;
}

void scale(RootHeights& k, std::int32_t radius) {
    for (auto& grid : k)
        for (auto& value : grid) value = dequantize(value, radius);
}

}  // namespace

EncodedRoots encode_roots(const RootHeights& source, int n, std::int32_t radius) {
    BitWriter bits;
    EncodedRoots out;
    out.heights = visit_roots(n, [&](int face, std::size_t position, std::int32_t prediction) {
        const std::int32_t k = quantize(source[static_cast<std::size_t>(face)][position], radius);
        put_gamma(bits, wrapping_sub(k, prediction));
        return k;
    });
    scale(out.heights, radius);
    out.bytes = bits.finish();
    return out;
}

RootHeights decode_roots(std::span<const std::byte> bytes, int n, std::int32_t radius,
                         const std::string& file) {
    try {
        BitReader bits(bytes);
        RootHeights k = visit_roots(n, [&](int, std::size_t, std::int32_t prediction) {
            return wrapping_add(prediction, take_gamma(bits));
        });
        bits.finish();
        scale(k, radius);
        return k;
    } catch (const Error& e) {
        throw Error(e.code(), file + ": root values: " + e.what());
    }
}

}  // namespace carat
