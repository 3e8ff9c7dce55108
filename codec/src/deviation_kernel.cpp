#include "deviation_kernel.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "deviation_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carat::kernel::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A row of fine vertices from (x, y)/8 on, each (xj, yj)/8 after the one before.
struct FineRow {
    const std::int32_t* fine;
    std::int32_t x, y, xj, yj;
};

// Sums are taken mod 2^32: what carries no weight cancels, even if it is no height at all.
HWY_INLINE std::int32_t deviation(const std::int32_t* coarse, std::int32_t n, const FineRow& row,
                                  std::int32_t k) {
    const std::int32_t x = row.x + k * row.xj, y = row.y + k * row.yj;
    const std::int32_t i = std::min(x >> 3, n - 2), j = std::min(y >> 3, n - 2);
    const std::int32_t fx = x - 8 * i, fy = y - 8 * j;
    const std::int32_t* at = coarse + static_cast<std::ptrdiff_t>(i) * n + j;
    const auto p00 = static_cast<std::uint32_t>(at[0]), p01 = static_cast<std::uint32_t>(at[1]),
               p10 = static_cast<std::uint32_t>(at[n]), p11 = static_cast<std::uint32_t>(at[n + 1]);
    const std::int32_t share = ((i ^ j) & 1) == 0 ? std::max(fx - fy, 0) : std::min(fx, 8 - fy);
    const std::uint32_t sum = 8 * (p00 - static_cast<std::uint32_t>(row.fine[k])) +
                              static_cast<std::uint32_t>(fy) * (p01 - p00) +
                              static_cast<std::uint32_t>(fx) * (p11 - p01) +
                              static_cast<std::uint32_t>(share) * (p10 + p01 - p00 - p11);
    return std::abs(static_cast<std::int32_t>(sum));
}

template <class D, class V>
HWY_INLINE V deviations(D d, const std::int32_t* coarse, std::int32_t n, const FineRow& row, std::int32_t k,
                        V steps_x, V steps_y) {
    const auto last = hn::Set(d, n - 2), zero = hn::Zero(d), eight = hn::Set(d, 8);
    const auto x = hn::Add(hn::Set(d, row.x + k * row.xj), steps_x),
               y = hn::Add(hn::Set(d, row.y + k * row.yj), steps_y);
    const auto i = hn::Min(hn::ShiftRight<3>(x), last), j = hn::Min(hn::ShiftRight<3>(y), last);
    const auto fx = hn::Sub(x, hn::ShiftLeft<3>(i)), fy = hn::Sub(y, hn::ShiftLeft<3>(j));
    const auto at = hn::Add(hn::Mul(i, hn::Set(d, n)), j);
    const auto p00 = hn::GatherIndex(d, coarse, at), p01 = hn::GatherIndex(d, coarse + 1, at),
               p10 = hn::GatherIndex(d, coarse + n, at), p11 = hn::GatherIndex(d, coarse + n + 1, at);
    const auto anti = hn::Ne(hn::And(hn::Xor(i, j), hn::Set(d, 1)), zero);
    const auto share = hn::IfThenElse(anti, hn::Min(fx, hn::Sub(eight, fy)), hn::Max(hn::Sub(fx, fy), zero));
    const auto east = hn::Sub(p01, p00), south = hn::Sub(p11, p01);
    auto sum = hn::ShiftLeft<3>(hn::Sub(p00, hn::LoadU(d, row.fine + k)));
    sum = hn::Add(sum, hn::Add(hn::Mul(fy, east), hn::Mul(fx, south)));
    sum = hn::Add(sum, hn::Mul(share, hn::Sub(hn::Add(p10, p01), hn::Add(p00, p11))));
    return hn::Abs(sum);
}

std::int32_t MaxDeviation(const std::int32_t* coarse, const std::int32_t* fine, const FinePlacement& m,
                          int side, int n) {
    const hn::CappedTag<std::int32_t, 16> d;
    const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
    const auto steps_x = hn::Mul(hn::Iota(d, 0), hn::Set(d, m.xj)),
               steps_y = hn::Mul(hn::Iota(d, 0), hn::Set(d, m.yj));
    auto most = hn::Zero(d);
    std::int32_t worst = 0;
    for (std::int32_t i = 0; i < n; ++i) {
        const std::int32_t begin = side == 0 ? 0 : i, count = side == 0 ? i + 1 : n - i;
        const FineRow row{fine + static_cast<std::ptrdiff_t>(i) * n + begin, m.x0 + i * m.xi + begin * m.xj,
                          m.y0 + i * m.yi + begin * m.yj, m.xj, m.yj};
        if (count < lanes) {
            for (std::int32_t k = 0; k < count; ++k) worst = std::max(worst, deviation(coarse, n, row, k));
            continue;
        }
        for (std::int32_t k = 0; k + lanes <= count; k += lanes)
            most = hn::Max(most, deviations(d, coarse, n, row, k, steps_x, steps_y));
        // The last ones may overlap those before.
        if (count % lanes != 0)
            most = hn::Max(most, deviations(d, coarse, n, row, count - lanes, steps_x, steps_y));
    }
    return std::max(worst, hn::GetLane(hn::MaxOfLanes(d, most)));
}

}  // namespace carat::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat::kernel {

HWY_EXPORT(MaxDeviation);

std::int32_t max_deviation(const std::int32_t* coarse, const std::int32_t* fine, const FinePlacement& place,
                           int side, int n) {
    return HWY_DYNAMIC_DISPATCH(MaxDeviation)(coarse, fine, place, side, n);
}

}  // namespace carat::kernel
#endif  // HWY_ONCE
