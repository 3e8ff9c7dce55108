#include "carat/codec/summary.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdlib>

#include "deviation_kernel.hpp"

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

// How much of p10 + p01 - p00 - p11 the 4-8 triangles of a cell add at (fx, fy)/8 to the plane through p00,
// p01 and p11: the diagonal of the cell runs from p00 to p11 (main) or from p10 to p01.
struct DiagonalShare {
    std::array<std::array<std::array<std::int8_t, kOne + 1>, kOne + 1>, 2> of{};  // [anti][fx][fy]

    constexpr DiagonalShare() {
        for (int fx = 0; fx <= kOne; ++fx)
            for (int fy = 0; fy <= kOne; ++fy) {
                of[0][static_cast<std::size_t>(fx)][static_cast<std::size_t>(fy)] =
                    static_cast<std::int8_t>(fx > fy ? fx - fy : 0);
                of[1][static_cast<std::size_t>(fx)][static_cast<std::size_t>(fy)] =
                    static_cast<std::int8_t>(fx < kOne - fy ? fx : kOne - fy);
            }
    }
};
constexpr DiagonalShare kShare;

// 8 times the height of the coarse surface at index position (x, y)/8. Without branches: which triangle a
// place lies in is hard to foresee.
std::int64_t interpolate(const std::int32_t* p, int n, int x, int y) {
    const int i = std::min(x / kOne, n - 2), j = std::min(y / kOne, n - 2);
    const auto fx = static_cast<std::size_t>(x - i * kOne), fy = static_cast<std::size_t>(y - j * kOne);
    const std::int32_t* at = p + static_cast<std::ptrdiff_t>(i) * n + j;
    const std::int64_t p00 = at[0], p01 = at[1], p10 = at[n], p11 = at[n + 1];
    const std::int64_t share = kShare.of[static_cast<std::size_t>((i ^ j) & 1)][fx][fy];
    return kOne * p00 + static_cast<std::int64_t>(fy) * (p01 - p00) +
           static_cast<std::int64_t>(fx) * (p11 - p01) + share * (p10 + p01 - p00 - p11);
}

constexpr std::int64_t kNarrow = 1 << 25;  // what the vectorised loop needs

// Greatest minus least value of two halves together.
std::int64_t spread(const std::int32_t* a, int n, int side_a, const std::int32_t* b, int side_b) {
    std::int32_t low = INT32_MAX, high = INT32_MIN;
    const auto look = [&](const std::int32_t* p, int side) {
        for (int i = 0; i < n; ++i) {
            const std::int32_t *at = p + static_cast<std::ptrdiff_t>(i) * n + (side == 0 ? 0 : i),
                               *end = p + static_cast<std::ptrdiff_t>(i) * n + (side == 0 ? i + 1 : n);
            for (; at != end; ++at) {
                low = std::min(low, *at);
                high = std::max(high, *at);
            }
        }
    };
    look(a, side_a);
    look(b, side_b);
    return std::int64_t{high} - low;
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
    std::uint32_t widest = 0;
    for (int i = 0; i + 1 < n; ++i) {
        const std::int32_t *row = p + static_cast<std::ptrdiff_t>(i) * n, *below = row + n;
        // The far corner of a cell on the longest edge belongs to the other half.
        const std::int32_t corner = side == 0 ? below[i] : row[i + 1];
        const std::int32_t low = std::min({row[i], corner, below[i + 1]});
        const std::int32_t high = std::max({row[i], corner, below[i + 1]});
        widest = std::max(widest, static_cast<std::uint32_t>(high) - static_cast<std::uint32_t>(low));
        for (int j = side == 0 ? 0 : i + 1; j < (side == 0 ? i : n - 1); ++j) {
            const std::int32_t least =
                std::min(std::min(row[j], row[j + 1]), std::min(below[j], below[j + 1]));
            const std::int32_t most =
                std::max(std::max(row[j], row[j + 1]), std::max(below[j], below[j + 1]));
            widest = std::max(widest, static_cast<std::uint32_t>(most) - static_cast<std::uint32_t>(least));
        }
    }
    r.cell_range = widest;
    return r;
}

std::int64_t max_deviation(const std::int32_t* coarse, const Half& coarse_half, const std::int32_t* fine,
                           const Half& fine_half, int n) {
    const HalfFrame c = half_frame(coarse_half, n - 1), f = half_frame(fine_half, n - 1);
    const LatticeVector origin = f.origin - c.origin;
    const kernel::FinePlacement at{eighths(origin, c.u), eighths(f.u, c.u), eighths(f.v, c.u),
                                   eighths(origin, c.v), eighths(f.u, c.v), eighths(f.v, c.v)};
    if (spread(coarse, n, coarse_half.side, fine, fine_half.side) <= kNarrow)
        return kernel::max_deviation(coarse, fine, at, fine_half.side, n);
    std::int64_t worst = 0;
    for (int i = 0; i < n; ++i)
        for (int j = fine_half.side == 0 ? 0 : i; j < (fine_half.side == 0 ? i + 1 : n); ++j) {
            const std::int64_t there =
                interpolate(coarse, n, at.x0 + i * at.xi + j * at.xj, at.y0 + i * at.yi + j * at.yj);
            worst = std::max(worst, std::abs(there - kOne * std::int64_t{fine[i * n + j]}));
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
