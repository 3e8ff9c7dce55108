#include "kernels.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <type_traits>

#include "range_model.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace carat::kernel::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A weighted sum of samples divided by 2^kBits with rounding half up, modulo 2^32. Exact for all int32
// samples: floor((sum w x + 2^(kBits-1)) / 2^kBits) = sum w (x >> kBits) + ((sum w (x mod 2^kBits) +
// 2^(kBits-1)) >> kBits), since the second sum is far from overflow and the first is wanted modulo 2^32 only.
// kNarrow: plain sums, for samples so small that these cannot overflow.
template <class D, int kBits, bool kNarrow>
class Sum {
  public:
    using DU = hn::RebindToUnsigned<D>;
    using V = hn::Vec<D>;
    using VU = hn::Vec<DU>;
    HWY_INLINE explicit Sum(D d) : d_(d), mask_(hn::Set(d, (1 << kBits) - 1)) {}

    struct Parts {
        VU high;
        V low;
    };
    HWY_INLINE Parts at(const std::int32_t* p) const {
        const V x = hn::LoadU(d_, p);
        if constexpr (kNarrow)
            return {hn::Zero(DU()), x};
        else
            return {hn::BitCast(DU(), hn::ShiftRight<kBits>(x)), hn::And(x, mask_)};
    }
    template <class... P>
    HWY_INLINE Parts of(const std::int32_t* first, P... rest) const {
        Parts sum = at(first);
        (add(sum, at(rest)), ...);
        return sum;
    }
    HWY_INLINE static void add(Parts& a, const Parts& b) {
        if constexpr (!kNarrow) a.high = hn::Add(a.high, b.high);
        a.low = hn::Add(a.low, b.low);
    }
    HWY_INLINE void add_times(Parts& a, std::int32_t w, const Parts& b) const {
        if constexpr (!kNarrow)
            a.high = hn::Add(a.high, hn::Mul(b.high, hn::Set(DU(), static_cast<std::uint32_t>(w))));
        a.low = hn::Add(a.low, hn::Mul(b.low, hn::Set(d_, w)));
    }
    HWY_INLINE void subtract(Parts& a, const Parts& b) const {
        if constexpr (!kNarrow) a.high = hn::Sub(a.high, b.high);
        a.low = hn::Sub(a.low, b.low);
    }
    HWY_INLINE Parts zero() const { return {hn::Zero(DU()), hn::Zero(d_)}; }
    HWY_INLINE V divided(const Parts& a) const {
        const V low = hn::ShiftRight<kBits>(hn::Add(a.low, hn::Set(d_, 1 << (kBits - 1))));
        if constexpr (kNarrow) return low;
        return hn::BitCast(d_, hn::Add(a.high, hn::BitCast(DU(), low)));
    }

  private:
    D d_;
    V mask_;
};

// The greatest sum of |weights| is 944 (order 6): samples below 2^21 cannot overflow 2^31.
constexpr std::uint32_t kNarrowSamples = 1u << 21;

// All of |x| <= 2^21?
HWY_INLINE bool are_narrow(const std::int32_t* x, std::ptrdiff_t count) {
    std::uint32_t all = 0;
    for (std::ptrdiff_t k = 0; k < count; ++k)
        all |= static_cast<std::uint32_t>(x[k]) ^ static_cast<std::uint32_t>(x[k] >> 31);
    return all < kNarrowSamples;
}

template <bool kNarrow>
HWY_INLINE void mean_row(const std::int32_t* a, const std::int32_t* b, int cells, std::int32_t* out) {
    for_lanes(0, cells, [&](auto d, std::ptrdiff_t j) CARAT_INLINE_LAMBDA {
        const Sum<decltype(d), 2, kNarrow> s(d);
        hn::StoreU(s.divided(s.of(a + j, a + j + 1, b + j, b + j + 1)), d, out + j);
    });
}

// Cells j_begin to j_end - 1 of a row; r1: its upper vertices.
template <bool kNarrow>
HWY_NOINLINE void order4_cells(const std::int32_t* r1, std::ptrdiff_t m, std::ptrdiff_t j_begin,
                               std::ptrdiff_t j_end, std::int32_t* out) {
    const std::int32_t *r0 = r1 - m, *r2 = r1 + m, *r3 = r2 + m;
    for_lanes(j_begin, j_end, [&](auto d, std::ptrdiff_t j) CARAT_INLINE_LAMBDA {
        const Sum<decltype(d), 5, kNarrow> s(d);
        auto sum = s.zero();
        s.add_times(sum, 10, s.of(r1 + j, r1 + j + 1, r2 + j, r2 + j + 1));
        s.subtract(sum, s.of(r0 + j, r0 + j + 1, r3 + j, r3 + j + 1, r1 + j - 1, r1 + j + 2, r2 + j - 1,
                             r2 + j + 2));
        hn::StoreU(s.divided(sum), d, out + j);
    });
}

template <bool kNarrow>
HWY_INLINE void order6_row(const std::int32_t* r1, std::ptrdiff_t m, std::int32_t* out) {
    const std::int32_t *r0 = r1 - m, *rz = r0 - m, *r2 = r1 + m, *r3 = r2 + m, *r4 = r3 + m;
    for_lanes(2, m - 3, [&](auto d, std::ptrdiff_t j) CARAT_INLINE_LAMBDA {
        const Sum<decltype(d), 9, kNarrow> s(d);
        auto sum = s.zero();
        s.add_times(sum, 174, s.of(r1 + j, r1 + j + 1, r2 + j, r2 + j + 1));
        s.add_times(
            sum, -27,
            s.of(r0 + j, r0 + j + 1, r3 + j, r3 + j + 1, r1 + j - 1, r1 + j + 2, r2 + j - 1, r2 + j + 2));
        s.add_times(sum, 2, s.of(r0 + j - 1, r0 + j + 2, r3 + j - 1, r3 + j + 2));
        s.add_times(
            sum, 3,
            s.of(rz + j, rz + j + 1, r4 + j, r4 + j + 1, r1 + j - 2, r1 + j + 3, r2 + j - 2, r2 + j + 3));
        hn::StoreU(s.divided(sum), d, out + j);
    });
}

// Border cells of orders 4 and 6: two rows a and b along the border, samples `step` apart.
HWY_INLINE std::int32_t one_sided(const std::int32_t* a, const std::int32_t* b, std::ptrdiff_t step) {
    const std::int64_t inner = std::int64_t{a[0]} + a[step] + b[0] + b[step];
    const std::int64_t outer = std::int64_t{a[-step]} + a[2 * step] + b[-step] + b[2 * step];
    return static_cast<std::int32_t>(static_cast<std::uint32_t>((9 * inner - outer + 16) >> 5));
}
template <bool kNarrow>
HWY_INLINE void border_row(const std::int32_t* a, const std::int32_t* b, std::ptrdiff_t m,
                           std::int32_t* out) {
    mean_row<false>(a, b, 1, out);
    mean_row<false>(a + m - 2, b + m - 2, 1, out + m - 2);
    for_lanes(1, m - 2, [&](auto d, std::ptrdiff_t j) CARAT_INLINE_LAMBDA {
        const Sum<decltype(d), 5, kNarrow> s(d);
        auto sum = s.zero();
        s.add_times(sum, 9, s.of(a + j, a + j + 1, b + j, b + j + 1));
        s.subtract(sum, s.of(a + j - 1, a + j + 2, b + j - 1, b + j + 2));
        hn::StoreU(s.divided(sum), d, out + j);
    });
}

template <bool kNarrow>
HWY_INLINE void predict_all(const std::int32_t* in, std::ptrdiff_t width, Order order, std::int32_t* out) {
    const std::ptrdiff_t cells = width - 1, last = width - 2;
    if (order == Order::two) {
        for (std::ptrdiff_t i = 0; i < cells; ++i)
            mean_row<kNarrow>(in + i * width, in + (i + 1) * width, static_cast<int>(cells), out + i * cells);
        return;
    }
    border_row<kNarrow>(in, in + width, width, out);
    border_row<kNarrow>(in + last * width, in + (last + 1) * width, width, out + last * cells);
    for (std::ptrdiff_t i = 1; i < last; ++i) {
        const std::int32_t* row = in + i * width;
        std::int32_t* to = out + i * cells;
        to[0] = one_sided(row, row + 1, width);
        to[last] = one_sided(row + last, row + last + 1, width);
        if (order == Order::six && i >= 2 && i < last - 1) {
            order4_cells<kNarrow>(row, width, 1, 2, to);
            order4_cells<kNarrow>(row, width, last - 1, last, to);
            order6_row<kNarrow>(row, width, to);
        } else {
            order4_cells<kNarrow>(row, width, 1, last, to);
        }
    }
}

// --- orders 4 and 6 of narrow samples: sums along each row of vertices once, then sums of those ---

constexpr std::ptrdiff_t kFoldPitch = 128, kFoldRows = 8;  // cells of a row at most; a power of two

// Of a vertex row, by column of cells: its share in the cells beside it, in those one row on, and two rows
// on.
struct Folds {
    alignas(64) std::int32_t beside[kFoldRows][kFoldPitch], next[kFoldRows][kFoldPitch],
        outer[kFoldRows][kFoldPitch];
};

// Columns begin, begin + 1, ... of a row to `count` or up to a vector more: reads, and writes, that much.
template <bool kSix>
HWY_INLINE void fold_row(const std::int32_t* row, std::ptrdiff_t count, std::size_t at, Folds& folds) {
    const hn::ScalableTag<std::int32_t> d;
    for (std::ptrdiff_t j = 0; j < count; j += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
        const auto pair = [&](std::ptrdiff_t k) CARAT_INLINE_LAMBDA {
            return hn::Add(hn::LoadU(d, row + j - k), hn::LoadU(d, row + j + 1 + k));
        };
        const auto times = [&](auto x, std::int32_t w)
                               CARAT_INLINE_LAMBDA { return hn::Mul(x, hn::Set(d, w)); };
        const auto inner = pair(0), sides = pair(1);
        if constexpr (kSix) {
            const auto five = hn::Add(sides, hn::ShiftLeft<2>(sides)), far = pair(2);
            const auto sides27 = hn::Sub(hn::ShiftLeft<5>(sides), five);
            const auto thrice = hn::Add(inner, hn::ShiftLeft<1>(inner));
            hn::Store(hn::Add(hn::Sub(times(inner, 174), sides27), hn::Add(far, hn::ShiftLeft<1>(far))), d,
                      folds.beside[at] + j);
            hn::Store(hn::Sub(hn::ShiftLeft<1>(sides), times(thrice, 9)), d, folds.next[at] + j);
            hn::Store(thrice, d, folds.outer[at] + j);
        } else {
            const auto five = hn::Add(inner, hn::ShiftLeft<2>(inner));
            hn::Store(hn::Sub(hn::ShiftLeft<1>(five), sides), d, folds.beside[at] + j);
            hn::Store(inner, d, folds.next[at] + j);
        }
    }
}

// Row i of cells, out of folds of the vertex rows around it; up to a vector more than `count` is written.
template <bool kSix>
HWY_INLINE void sum_folds(const Folds& folds, std::size_t i, std::ptrdiff_t count, std::int32_t* out) {
    const hn::ScalableTag<std::int32_t> d;
    const auto row = [&](const auto& of, std::size_t k) CARAT_INLINE_LAMBDA { return of[k % kFoldRows]; };
    for (std::ptrdiff_t j = 0; j < count; j += static_cast<std::ptrdiff_t>(hn::Lanes(d))) {
        const auto two = [&](const auto& of, std::size_t k) CARAT_INLINE_LAMBDA {
            return hn::Add(hn::Load(d, row(of, i - k) + j), hn::Load(d, row(of, i + 1 + k) + j));
        };
        const auto beside = two(folds.beside, 0), next = two(folds.next, 1);
        if constexpr (kSix) {
            const auto sum = hn::Add(hn::Add(beside, next), two(folds.outer, 2));
            hn::StoreU(hn::ShiftRight<9>(hn::Add(sum, hn::Set(d, 256))), d, out + j);
        } else {
            hn::StoreU(hn::ShiftRight<5>(hn::Add(hn::Sub(beside, next), hn::Set(d, 16))), d, out + j);
        }
    }
}

// Cells of a border column; a, b: sums of the two samples of a row there, from one row above the cell on.
HWY_INLINE std::int32_t one_sided_narrow(const std::int32_t* sums) {
    return (9 * (sums[1] + sums[2]) - (sums[0] + sums[3]) + 16) >> 5;
}

// As predict_all<true>. Rows are written some values too far; what follows is written later.
template <bool kSix>
HWY_INLINE void predict_folded(const std::int32_t* in, std::ptrdiff_t width, std::int32_t* out) {
    constexpr std::ptrdiff_t kReach = kSix ? 2 : 1;  // cells along the border that have a rule of their own
    const std::ptrdiff_t cells = width - 1, last = width - 2, count = cells - 2 * kReach;
    std::int32_t left[kFoldPitch + 1], right[kFoldPitch + 1], end[2 * kFoldPitch] = {};
    for (std::ptrdiff_t i = 0; i < width; ++i) {
        left[i] = in[i * width] + in[i * width + 1];
        right[i] = in[i * width + last] + in[i * width + last + 1];
    }
    std::copy_n(in + cells * width, width, end);  // with something behind it
    Folds folds;
    const auto row_of_cells = [&](std::ptrdiff_t i, auto interior) CARAT_INLINE_LAMBDA {
        std::int32_t* to = out + i * cells;
        interior(in + i * width, to);
        to[0] = one_sided_narrow(left + i - 1);
        to[last] = one_sided_narrow(right + i - 1);
    };
    const auto all_order4 = [&](const std::int32_t* row, std::int32_t* to)
                                CARAT_INLINE_LAMBDA { order4_cells<true>(row, width, 1, last, to); };
    border_row<true>(in, in + width, width, out);
    if (kSix) row_of_cells(1, all_order4);
    for (std::ptrdiff_t v = 0; v < width; ++v) {
        const std::int32_t* vertices = v < cells ? in + v * width : end;
        fold_row<kSix>(vertices + kReach, count, static_cast<std::size_t>(v % kFoldRows), folds);
        const std::ptrdiff_t i = v - kReach - 1;
        if (i < kReach) continue;
        row_of_cells(i, [&](const std::int32_t* row, std::int32_t* to) CARAT_INLINE_LAMBDA {
            sum_folds<kSix>(folds, static_cast<std::size_t>(i), count, to + kReach);
            if (!kSix) return;
            order4_cells<true>(row, width, 1, 2, to);
            order4_cells<true>(row, width, last - 1, last, to);
        });
    }
    if (kSix) row_of_cells(last - 1, all_order4);
    border_row<true>(in + last * width, in + (last + 1) * width, width, out + last * cells);
}

void Predict(const std::int32_t* in, int m, Order order, std::int32_t* out) {
    const hn::ScalableTag<std::int32_t> d;
    // For what is read too far, and for the folds.
    const bool folds = static_cast<std::size_t>(m) >= hn::Lanes(d) + 8 && m <= kFoldPitch + 1;
    if (!are_narrow(in, static_cast<std::ptrdiff_t>(m) * m))
        predict_all<false>(in, m, order, out);
    else if (order == Order::four && folds)
        predict_folded<false>(in, m, out);
    else if (order == Order::six && folds)
        predict_folded<true>(in, m, out);
    else
        predict_all<true>(in, m, order, out);
}

constexpr std::uint32_t kMostDifference = 1u << 23;

// min(|x| >> shift, 2^23) of x, a difference modulo 2^32.
template <class DU>
HWY_INLINE hn::Vec<DU> magnitude(DU du, hn::Vec<DU> x, int shift) {
    const hn::RebindToSigned<DU> d;
    const auto u = hn::BitCast(du, hn::Abs(hn::BitCast(d, x)));  // 2^31 for the least int32
    return hn::Min(hn::ShiftRightSame(u, shift), hn::Set(du, kMostDifference));
}

// |second differences| of vertex row i, into the row of the padded matrix.
HWY_INLINE void vertex_row(const std::int32_t* in, std::ptrdiff_t m, std::ptrdiff_t i, int shift,
                           std::uint32_t* out) {
    const std::int32_t* row = in + i * m;
    const std::int32_t* middle = in + std::clamp<std::ptrdiff_t>(i, 1, m - 2) * m;
    const auto store = [&](auto d, std::ptrdiff_t j, const std::int32_t* centre) CARAT_INLINE_LAMBDA {
        const hn::RebindToUnsigned<decltype(d)> du;
        const auto second = [&](const std::int32_t* p, std::ptrdiff_t step) {
            const auto sides = hn::Add(load_unsigned(du, p - step), load_unsigned(du, p + step));
            return magnitude(du, hn::Sub(sides, hn::ShiftLeft<1>(load_unsigned(du, p))), shift);
        };
        hn::StoreU(hn::Add(second(centre, 1), second(middle + j, m)), du, out + j);
    };
    const hn::CappedTag<std::int32_t, 1> one;
    store(one, 0, row + 1);
    store(one, m - 1, row + m - 2);
    for_lanes(1, m - 1, [&](auto d, std::ptrdiff_t j) CARAT_INLINE_LAMBDA { store(d, j, row + j); });
    out[-1] = out[0];
    out[m] = out[m - 1];
}

// 1 2 2 1 along a padded row: out[j] belongs to cell column j.
HWY_INLINE void weigh_row(const std::uint32_t* in, std::ptrdiff_t cells, std::uint32_t* out) {
    for_lanes(0, cells, [&](auto ds, std::ptrdiff_t j) CARAT_INLINE_LAMBDA {
        const hn::RebindToUnsigned<decltype(ds)> d;
        const auto outer = hn::Add(hn::LoadU(d, in + j - 1), hn::LoadU(d, in + j + 2));
        const auto inner = hn::Add(hn::LoadU(d, in + j), hn::LoadU(d, in + j + 1));
        hn::StoreU(hn::Add(outer, hn::ShiftLeft<1>(inner)), d, out + j);
    });
}

// Around each cell: rows of `vertices` are `stride` apart.
HWY_INLINE void window_activity(const std::int32_t* in, std::ptrdiff_t m, const ActivityScale& scale,
                                const std::uint32_t* vertices, std::ptrdiff_t stride, std::uint32_t* rows,
                                std::uint32_t* out) {
    const std::ptrdiff_t cells = m - 1;
    for (std::ptrdiff_t i = 0; i < m; ++i) weigh_row(vertices + i * stride, cells, rows + (i + 1) * cells);
    std::copy(rows + cells, rows + 2 * cells, rows);
    std::copy(rows + m * cells, rows + (m + 1) * cells, rows + (m + 1) * cells);
    for (std::ptrdiff_t i = 0; i < cells; ++i)
        for_lanes(0, cells, [&](auto ds, std::ptrdiff_t j) CARAT_INLINE_LAMBDA {
            const hn::RebindToUnsigned<decltype(ds)> d;
            const std::uint32_t* r = rows + i * cells + j;
            const std::int32_t *a = in + i * m + j, *b = a + m;
            const auto outer = hn::Add(hn::LoadU(d, r), hn::LoadU(d, r + 3 * cells));
            const auto inner = hn::Add(hn::LoadU(d, r + cells), hn::LoadU(d, r + 2 * cells));
            const auto twist = hn::Sub(hn::Add(load_unsigned(d, a), load_unsigned(d, b + 1)),
                                       hn::Add(load_unsigned(d, a + 1), load_unsigned(d, b)));
            const auto sum = hn::Add(hn::Add(outer, hn::ShiftLeft<1>(inner)),
                                     hn::ShiftLeft<3>(magnitude(d, twist, scale.shift)));
            hn::StoreU(hn::Add(sum, hn::Set(d, 24 * scale.step)), d, out + i * cells + j);
        });
}

// At each cell's corners.
HWY_INLINE void corner_activity(const std::int32_t* in, std::ptrdiff_t m, const ActivityScale& scale,
                                const std::uint32_t* vertices, std::ptrdiff_t stride, std::uint32_t* out) {
    const std::ptrdiff_t cells = m - 1;
    for (std::ptrdiff_t i = 0; i < cells; ++i)
        for_lanes(0, cells, [&](auto ds, std::ptrdiff_t j) CARAT_INLINE_LAMBDA {
            const hn::RebindToUnsigned<decltype(ds)> d;
            const std::uint32_t *r = vertices + i * stride + j, *s = r + stride;
            const auto rough = hn::Add(hn::Add(hn::LoadU(d, r), hn::LoadU(d, r + 1)),
                                       hn::Add(hn::LoadU(d, s), hn::LoadU(d, s + 1)));
            const std::int32_t *p = in + i * m + j, *q = p + m;
            const auto ka = load_unsigned(d, p), kb = load_unsigned(d, p + 1), kc = load_unsigned(d, q),
                       kd = load_unsigned(d, q + 1);
            const auto total = hn::Add(hn::Add(ka, kb), hn::Add(kc, kd));
            const auto off = [&](auto x) CARAT_INLINE_LAMBDA {
                return magnitude(d, hn::Sub(hn::ShiftLeft<2>(x), total), scale.shift);
            };
            const auto spread = hn::Add(hn::Add(off(ka), off(kb)), hn::Add(off(kc), off(kd)));
            const auto seven = hn::Sub(hn::ShiftLeft<3>(spread), spread);
            const auto sum = hn::Add(hn::Add(hn::ShiftLeft<2>(rough), rough), seven);
            hn::StoreU(hn::Add(sum, hn::Set(d, 24 * scale.step)), d, out + i * cells + j);
        });
}

void CellActivity(const std::int32_t* in, int size, const ActivityScale& scale, Activity kind,
                  ActivityScratch& scratch, std::uint32_t* out) {
    const std::ptrdiff_t m = size, cells = m - 1, stride = m + 2;
    scratch.vertices.resize(static_cast<std::size_t>(m * stride));
    scratch.rows.resize(static_cast<std::size_t>((m + 2) * cells));
    // One sweep after another: a row that was just stored cannot be read at another alignment without a
    // stall.
    std::uint32_t* vertices = scratch.vertices.data() + 1;
    for (std::ptrdiff_t i = 0; i < m; ++i) vertex_row(in, m, i, scale.shift, vertices + i * stride);
    if (kind == Activity::corners)
        corner_activity(in, m, scale, vertices, stride, out);
    else
        window_activity(in, m, scale, vertices, stride, scratch.rows.data(), out);
}

// x >= 1.
template <class D>
HWY_INLINE hn::Vec<D> floor_log2(D d, hn::Vec<D> x) {
    auto e = hn::Zero(d);
    const auto halve = [&](auto shift) CARAT_INLINE_LAMBDA {
        constexpr int kShift = decltype(shift)::value;
        const auto big = hn::Gt(x, hn::Set(d, (1 << kShift) - 1));
        e = hn::Add(e, hn::IfThenElseZero(big, hn::Set(d, kShift)));
        x = hn::IfThenElse(big, hn::ShiftRight<kShift>(x), x);
    };
    halve(std::integral_constant<int, 16>{});
    halve(std::integral_constant<int, 8>{});
    halve(std::integral_constant<int, 4>{});
#if HWY_TARGET != HWY_SCALAR
    if constexpr (hn::MaxLanes(D()) >=
                  4) {  // the table needs 16 bytes; x is 1 to 15 now, 0 in the upper bytes
        const hn::Repartition<std::uint8_t, D> bytes;
        alignas(16) static constexpr std::uint8_t kLog2[16] = {0, 0, 1, 1, 2, 2, 2, 2,
                                                               3, 3, 3, 3, 3, 3, 3, 3};
        return hn::Add(
            e, hn::BitCast(d, hn::TableLookupBytes(hn::LoadDup128(bytes, kLog2), hn::BitCast(bytes, x))));
    }
#endif
    halve(std::integral_constant<int, 2>{});
    halve(std::integral_constant<int, 1>{});
    return e;
}

template <bool kNeighbours>
HWY_INLINE void contexts_of(const std::uint32_t* activity, const std::uint8_t* neighbours,
                            std::uint32_t weight, std::size_t count, int bias, std::uint8_t base,
                            std::uint8_t* out) {
    for_lanes(0, static_cast<std::ptrdiff_t>(count), [&](auto d, std::ptrdiff_t k) CARAT_INLINE_LAMBDA {
        const hn::RebindToUnsigned<decltype(d)> du;
        const hn::Rebind<std::uint8_t, decltype(d)> d8;
        auto u = hn::BitCast(d, hn::LoadU(du, activity + k));
        if constexpr (kNeighbours) {
            const auto near = hn::PromoteTo(d, hn::LoadU(d8, neighbours + k));
            u = hn::Add(u, hn::Mul(near, hn::Set(d, static_cast<std::int32_t>(weight))));
        }
        const auto e = floor_log2(d, hn::ShiftRight<3>(u));  // u >= 16
        // 8 log2 = 8 (e + 3) + the three bits below the highest = 8 e + (u >> e) + 16
        const auto log = hn::Add(hn::ShiftLeft<3>(e), hn::Shr(u, e));
        const auto context = hn::ShiftRight<1>(hn::Add(log, hn::Set(d, bias + 16)));
        const auto held = hn::Min(hn::Max(context, hn::Zero(d)), hn::Set(d, kPassContexts - 1));
        hn::StoreU(hn::DemoteTo(d8, hn::Add(held, hn::Set(d, base))), d8, out + k);
    });
}

void Contexts(const std::uint32_t* activity, const std::uint8_t* neighbours, std::uint32_t weight,
              std::size_t count, int bias, std::uint8_t base, std::uint8_t* out) {
    if (neighbours == nullptr)
        contexts_of<false>(activity, nullptr, 0, count, bias, base, out);
    else
        contexts_of<true>(activity, neighbours, weight, count, bias, base, out);
}

void Reconstruct(const std::int32_t* prediction, const std::int32_t* index, std::size_t count,
                 std::int32_t step, std::int32_t* value) {
    for_lanes(0, static_cast<std::ptrdiff_t>(count), [&](auto d, std::ptrdiff_t k) CARAT_INLINE_LAMBDA {
        const hn::RebindToUnsigned<decltype(d)> du;
        const auto residual =
            hn::Mul(load_unsigned(du, index + k), hn::Set(du, static_cast<std::uint32_t>(step)));
        hn::StoreU(hn::BitCast(d, hn::Add(load_unsigned(du, prediction + k), residual)), d, value + k);
    });
}

bool Quantize(const std::int32_t* target, const std::int32_t* prediction, std::size_t count,
              std::int32_t radius, std::int32_t* index) {
    const Quantizer quantizer(radius);
    std::int32_t any = 0;
    for (std::size_t k = 0; k < count; ++k) {
        index[k] = quantizer.index(static_cast<std::uint32_t>(target[k]) -
                                   static_cast<std::uint32_t>(prediction[k]));
        any |= index[k];
    }
    return any != 0;
}

}  // namespace carat::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat {

ActivityScale::ActivityScale(std::int32_t radius) {
    const std::uint32_t s = 2 * static_cast<std::uint32_t>(radius) + 1;
    shift = std::max(0, static_cast<int>(std::bit_width(s)) - 12);
    step = s >> shift;
}

namespace kernel {

HWY_EXPORT(Predict);
HWY_EXPORT(CellActivity);
HWY_EXPORT(Contexts);
HWY_EXPORT(Reconstruct);
HWY_EXPORT(Quantize);

void predict(const std::int32_t* in, int m, Order order, std::int32_t* out) {
    HWY_DYNAMIC_DISPATCH(Predict)(in, m, order, out);
}
void cell_activity(const std::int32_t* in, int m, const ActivityScale& scale, Activity kind,
                   ActivityScratch& scratch, std::uint32_t* out) {
    HWY_DYNAMIC_DISPATCH(CellActivity)(in, m, scale, kind, scratch, out);
}
void contexts(const std::uint32_t* activity, const std::uint8_t* neighbours, std::uint32_t weight,
              std::size_t count, int bias, std::uint8_t base, std::uint8_t* out) {
    HWY_DYNAMIC_DISPATCH(Contexts)(activity, neighbours, weight, count, bias, base, out);
}
void reconstruct(const std::int32_t* prediction, const std::int32_t* index, std::size_t count,
                 std::int32_t step, std::int32_t* value) {
    HWY_DYNAMIC_DISPATCH(Reconstruct)(prediction, index, count, step, value);
}
bool quantize(const std::int32_t* target, const std::int32_t* prediction, std::size_t count,
              std::int32_t radius, std::int32_t* index) {
    return HWY_DYNAMIC_DISPATCH(Quantize)(target, prediction, count, radius, index);
}

}  // namespace kernel
}  // namespace carat
#endif  // HWY_ONCE
