#include "tangent_table.hpp"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <cstdlib>

#include "carat/globe/sphere.hpp"
#include "carat/render/vertex_position.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tangent_table.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#include "vertex_lanes.inc"

void Tangents(double* x, std::size_t count) {
    const D d;
    for (std::size_t k = 0; k < count; k += hn::Lanes(d)) {
        const V v = hn::LoadU(d, x + k);
        const V t = tangent(Lanes{v}).v;
        hn::StoreU(hn::IfThenElse(hn::Eq(hn::Abs(v), hn::Set(d, 1.0)), v, t), d, x + k);
    }
}

}  // namespace carat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat {

HWY_EXPORT(Tangents);

void tangents_in_place(std::span<double> tangents) {
    assert(tangents.size() % 16 == 0);
    HWY_DYNAMIC_DISPATCH(Tangents)(tangents.data(), tangents.size());
}

// The coordinate is origin + i u + j v with u and v each 0 or +-step, so it takes few values. Along a row it
// rises by one step, or falls: then the table is in descending order.
TangentTable::TangentTable(const HalfFrame& f, int side, int axis, int cells) {
    const auto sign = [](std::int64_t x) { return x > 0 ? 1 : x < 0 ? -1 : 0; };
    const std::int64_t u = f.u[axis], v = f.v[axis], step = std::max(std::abs(u), std::abs(v));
    const int along_r = sign(side == 0 ? u : v), along_c = sign(side == 0 ? v : u);
    assert(u == sign(u) * step && v == sign(v) * step);
    along_row_ = along_c != 0;
    const int direction = along_c < 0 ? -1 : 1;
    per_row_ = along_r * direction;
    // Values of r per_row + c (or r per_row) over 0 <= c <= r <= cells.
    const int least = per_row_ < 0 ? -cells : 0;
    const int greatest = (per_row_ > 0 ? cells : 0) + (along_row_ && per_row_ >= 0 ? cells : 0);
    first_ = -least;
    const auto count = static_cast<std::size_t>(greatest - least + 1);
    const std::size_t padded = (count + 16 + 15) / 16 * 16;
    assert(padded <= tangents_.size());
    std::fill(tangents_.begin() + static_cast<std::ptrdiff_t>(count),
              tangents_.begin() + static_cast<std::ptrdiff_t>(padded), 0.0);
    constexpr double kScale = 1.0 / static_cast<double>(kLatticeExtent);
    for (std::size_t k = 0; k < count; ++k) {
        const std::int64_t x = f.origin[axis] + (least + static_cast<std::int64_t>(k)) * direction * step;
        tangents_[k] = static_cast<double>(x) * kScale;
    }
    if (count > 1)
        tangents_in_place({tangents_.data(), padded});
    else
        tangents_[0] = vertex_tangent(tangents_[0]);
}

}  // namespace carat
#endif
