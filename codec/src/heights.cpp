#include "carat/codec/heights.hpp"

#include <cassert>

#include "gather_kernel.hpp"

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

void gather_half(const RefinedHeights& parent, DiamondId parent_id, const Half& child_half,
                 std::int32_t* out) {
    gather_half(parent, child_map(parent_id, child_half, parent.n - 1),
                child_half.side == 0 ? Triangle::left_lower : Triangle::right_upper, out);
}

void gather_half(const RefinedHeights& parent, const ChildMap& map, Triangle part, std::int32_t* out) {
    kernel::gather_half(parent.v.data(), parent.c.data(), parent.n, map, part, out);
}

}  // namespace carat
