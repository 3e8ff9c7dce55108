#include "carat/codec/heights.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace carat {
namespace {

// Index coordinate of a lattice offset along one of a frame's orthogonal axes, doubled; exact.
int doubled(const LatticeVector& offset, const LatticeVector& axis) {
    const LatticeVector unit{axis.x == 0 ? 0 : (axis.x > 0 ? 1 : -1), axis.y == 0 ? 0 : (axis.y > 0 ? 1 : -1),
                             axis.z == 0 ? 0 : (axis.z > 0 ? 1 : -1)};
    return static_cast<int>(2 * dot(offset, unit) / dot(axis, unit));
}

}  // namespace

ChildMap child_map([[maybe_unused]] DiamondId parent, const Half& child_half, int cells) {
    const std::optional<Half> inside = parent_half(child_half);
    assert(inside && inside->diamond == parent);
    const HalfFrame coarse = half_frame(*inside, cells), fine = half_frame(child_half, cells);
    const LatticeVector origin = fine.origin - coarse.origin;
    return {doubled(origin, coarse.u), doubled(origin, coarse.v), doubled(fine.u, coarse.u),
            doubled(fine.u, coarse.v), doubled(fine.v, coarse.u), doubled(fine.v, coarse.v)};
}

// A child's steps are half diagonals of the parent's cells: p and q change by 1 with each j, so that V and C
// take turns along a row, each along a diagonal of its matrix.
void gather_half(const RefinedHeights& parent, DiamondId parent_id, const Half& child_half,
                 std::int32_t* out) {
    const int n = parent.n;
    const ChildMap m = child_map(parent_id, child_half, n - 1);
    for (int i = 0; i < n; ++i) {
        const int j_begin = child_half.side == 0 ? 0 : i, j_end = child_half.side == 0 ? i + 1 : n;
        std::int32_t* row = out + static_cast<std::ptrdiff_t>(i) * n;
        for (int first = j_begin; first < std::min(j_begin + 2, j_end); ++first) {
            const int p = m.p0 + i * m.pi + first * m.pj, q = m.q0 + i * m.qi + first * m.qj;
            const bool vertex = (p & 1) == 0;
            const int width = vertex ? n : n - 1;
            const std::int32_t* from = vertex ? parent.v.data() : parent.c.data();
            std::ptrdiff_t at = static_cast<std::ptrdiff_t>(p >> 1) * width + (q >> 1);
            const std::ptrdiff_t step = static_cast<std::ptrdiff_t>(m.pj) * width + m.qj;
            for (int j = first; j < j_end; j += 2, at += step) row[j] = from[at];
        }
    }
}

}  // namespace carat
