#include "gather_kernel.hpp"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gather_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carat::kernel::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Every `step`th value from `from` on.
struct Diagonal {
    const std::int32_t* from;
    std::int32_t step;

    HWY_INLINE std::int32_t at(std::ptrdiff_t k) const { return from[k * step]; }
    HWY_INLINE Diagonal after(std::ptrdiff_t k) const { return {from + k * step, step}; }
};

// out[k]: values of `even` and `odd` in turn, `even` first.
HWY_INLINE void take_turns_plainly(Diagonal even, Diagonal odd, std::ptrdiff_t count, std::int32_t* out) {
    for (std::ptrdiff_t k = 0; k < count; ++k) out[k] = k % 2 == 0 ? even.at(k / 2) : odd.at(k / 2);
}

#if HWY_TARGET == HWY_SCALAR || HWY_MAX_BYTES < 32
HWY_INLINE void take_turns(Diagonal even, Diagonal odd, std::ptrdiff_t count, std::int32_t* out) {
    take_turns_plainly(even, odd, count, out);
}
#else
// Sixteen values by two gathers; the last sixteen may overlap those before.
HWY_INLINE void take_turns(Diagonal even, Diagonal odd, std::ptrdiff_t count, std::int32_t* out) {
    const hn::CappedTag<std::int32_t, 8> d;
    const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d)), both = 2 * lanes;
    if (count < both) return take_turns_plainly(even, odd, count, out);
    const auto place = hn::Iota(d, 0);
    const auto even_places = hn::Mul(place, hn::Set(d, even.step)),
               odd_places = hn::Mul(place, hn::Set(d, odd.step));
    std::ptrdiff_t k = 0;
    for (; k + both <= count; k += both)
        hn::StoreInterleaved2(hn::GatherIndex(d, even.from + k / 2 * even.step, even_places),
                              hn::GatherIndex(d, odd.from + k / 2 * odd.step, odd_places), d, out + k);
    if (k == count) return;
    k = count - both;
    const Diagonal a = even.after((k + 1) / 2), b = odd.after(k / 2);  // at k even: even first
    const auto from_a = hn::GatherIndex(d, a.from, even_places),
               from_b = hn::GatherIndex(d, b.from, odd_places);
    if (k % 2 == 0)
        hn::StoreInterleaved2(from_a, from_b, d, out + k);
    else
        hn::StoreInterleaved2(from_b, from_a, d, out + k);
}
#endif

// A child's steps are half diagonals of the parent's cells: p and q change by 1 with each j, so that V and C
// take turns along a row, each along a diagonal of its matrix.
void GatherHalf(const std::int32_t* v, const std::int32_t* c, int size, const ChildMap& m, int side,
                std::int32_t* out) {
    const std::ptrdiff_t n = size;
    const Diagonal vertices{v, static_cast<std::int32_t>(m.pj * n + m.qj)},
        cells{c, static_cast<std::int32_t>(m.pj * (n - 1) + m.qj)};
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        const std::ptrdiff_t begin = side == 0 ? 0 : i, end = side == 0 ? i + 1 : n;
        const auto diagonal = [&](std::ptrdiff_t j) {
            const std::ptrdiff_t p = m.p0 + i * m.pi + j * m.pj, q = m.q0 + i * m.qi + j * m.qj;
            const bool vertex = (p & 1) == 0;
            return vertex ? Diagonal{v + (p >> 1) * n + (q >> 1), vertices.step}
                          : Diagonal{c + (p >> 1) * (n - 1) + (q >> 1), cells.step};
        };
        // A second diagonal that no value is taken of need not lie inside.
        const Diagonal first = diagonal(begin), second = begin + 1 < end ? diagonal(begin + 1) : first;
        take_turns(first, second, end - begin, out + i * n + begin);
    }
}

}  // namespace carat::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat::kernel {

HWY_EXPORT(GatherHalf);

void gather_half(const std::int32_t* v, const std::int32_t* c, int n, const ChildMap& map, int side,
                 std::int32_t* out) {
    HWY_DYNAMIC_DISPATCH(GatherHalf)(v, c, n, map, side, out);
}

}  // namespace carat::kernel
#endif  // HWY_ONCE
