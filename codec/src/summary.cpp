#include "carat/codec/summary.hpp"

#include <algorithm>
#include <cassert>
#include <cstdlib>

namespace carat {
namespace {

constexpr int kOne = 8;  // index steps of a descendant up to 6 levels deeper are multiples of 1/8

// Index of a lattice offset along one of a frame's orthogonal axes, in 1/8; exact.
int eighths(const LatticeVector& offset, const LatticeVector& axis) {
    const auto sign = [](std::int64_t x) { return x == 0 ? std::int64_t{0} : x > 0 ? std::int64_t{1} : -1; };
    const LatticeVector unit{sign(axis.x), sign(axis.y), sign(axis.z)};
    const std::int64_t numerator = kOne * dot(offset, unit), denominator = dot(axis, unit);
    assert(numerator % denominator == 0);
    return static_cast<int>(numerator / denominator);
}

// 8 times the height of the coarse surface at index position (x, y)/8.
std::int64_t interpolate(const std::int32_t* p, int n, int x, int y) {
    const int i = std::min(x / kOne, n - 2), j = std::min(y / kOne, n - 2);
    const int fx = x - i * kOne, fy = y - j * kOne;
    const std::int32_t* at = p + static_cast<std::ptrdiff_t>(i) * n + j;
    const std::int64_t p00 = at[0], p01 = at[1], p10 = at[n], p11 = at[n + 1];
    if (((i ^ j) & 1) == 0) {
        if (fx >= fy) return (kOne - fx) * p00 + (fx - fy) * p10 + fy * p11;
        return (kOne - fy) * p00 + fx * p11 + (fy - fx) * p01;
    }
    if (fx + fy <= kOne) return (kOne - fx - fy) * p00 + fx * p10 + fy * p01;
    return (kOne - fy) * p10 + (fx + fy - kOne) * p11 + (kOne - fx) * p01;
}

}  // namespace

HeightRange height_range(const std::int32_t* p, int n, int side) {
    HeightRange r{INT32_MAX, INT32_MIN, 0};
    for (int i = 0; i < n; ++i)
        for (int j = side == 0 ? 0 : i; j < (side == 0 ? i + 1 : n); ++j) {
            const std::int32_t h = p[i * n + j];
            r.min = std::min(r.min, h);
            r.max = std::max(r.max, h);
        }
    for (int i = 0; i + 1 < n; ++i)
        for (int j = side == 0 ? 0 : i; j < (side == 0 ? i + 1 : n - 1); ++j) {
            const std::int32_t a = p[i * n + j], d = p[(i + 1) * n + j + 1];
            // The far corner of a cell on the longest edge belongs to the other half.
            const std::int32_t down = side == 0 || i != j ? p[(i + 1) * n + j] : a;
            const std::int32_t right = side == 1 || i != j ? p[i * n + j + 1] : a;
            const auto [low, high] = std::minmax({a, down, right, d});
            r.cell_range = std::max(r.cell_range, std::int64_t{high} - low);
        }
    return r;
}

std::int64_t max_deviation(const std::int32_t* coarse, const Half& coarse_half, const std::int32_t* fine,
                           const Half& fine_half, int n) {
    const HalfFrame c = half_frame(coarse_half, n - 1), f = half_frame(fine_half, n - 1);
    const LatticeVector origin = f.origin - c.origin;
    const int x0 = eighths(origin, c.u), xi = eighths(f.u, c.u), xj = eighths(f.v, c.u);
    const int y0 = eighths(origin, c.v), yi = eighths(f.u, c.v), yj = eighths(f.v, c.v);
    std::int64_t worst = 0;
    for (int i = 0; i < n; ++i)
        for (int j = fine_half.side == 0 ? 0 : i; j < (fine_half.side == 0 ? i + 1 : n); ++j) {
            const std::int64_t at = interpolate(coarse, n, x0 + i * xi + j * xj, y0 + i * yi + j * yj);
            worst = std::max(worst, std::abs(at - kOne * std::int64_t{fine[i * n + j]}));
        }
    return worst;
}

double flat_patch_bound(const Ellipsoid& body, const Half& half, const HeightRange& range, double quantum,
                        int cells) {
    const double highest = quantum * static_cast<double>(std::max(std::abs(std::int64_t{range.min}),
                                                                  std::abs(std::int64_t{range.max})));
    return curvature_bound(body, half, cells)
        .of_heights(highest, quantum * static_cast<double>(range.cell_range));
}

}  // namespace carat
