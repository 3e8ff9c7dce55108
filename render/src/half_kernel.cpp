#include "half_kernel.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <limits>

#include "carat/globe/patch.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "half_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The operations of the scalar functions, in their order.
void NormalsAndGround(double a2, double b2, const Places& w, Places& normals, Places& ground) {
    const hn::CappedTag<double, 16> d;
    const auto a = hn::Set(d, a2), b = hn::Set(d, b2);
    for (std::size_t k = 0; k < 16; k += hn::Lanes(d)) {
        const auto x = hn::LoadU(d, &w[0][k]), y = hn::LoadU(d, &w[1][k]), z = hn::LoadU(d, &w[2][k]);
        const auto norm = hn::Sqrt(hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z)));
        const auto nx = hn::Div(x, norm), ny = hn::Div(y, norm), nz = hn::Div(z, norm);
        const auto ex = hn::Mul(a, nx), ey = hn::Mul(a, ny), ez = hn::Mul(b, nz);
        const auto length = hn::Sqrt(hn::Add(hn::Add(hn::Mul(ex, nx), hn::Mul(ey, ny)), hn::Mul(ez, nz)));
        hn::StoreU(nx, d, &normals[0][k]);
        hn::StoreU(ny, d, &normals[1][k]);
        hn::StoreU(nz, d, &normals[2][k]);
        hn::StoreU(hn::Div(ex, length), d, &ground[0][k]);
        hn::StoreU(hn::Div(ey, length), d, &ground[1][k]);
        hn::StoreU(hn::Div(ez, length), d, &ground[2][k]);
    }
}

// The greatest range within a triangle is the greatest difference along an edge: of each cell (r, c) its
// first row, its first column and its diagonal; of the cells on the half's diagonal, c = r, no first row, and
// the last row's edges besides.

HWY_INLINE void widen(WholeRange& out, std::int32_t x, std::int32_t y) {
    const auto [low, high] = std::minmax(x, y);
    out.least = std::min(out.least, low);
    out.greatest = std::max(out.greatest, high);
    out.in_triangle =
        std::max(out.in_triangle, static_cast<std::uint32_t>(high) - static_cast<std::uint32_t>(low));
}

WholeRange plain_range(const std::int32_t* heights, int cells) {
    WholeRange out{heights[0], heights[0], 0};
    const std::int32_t* row = heights;
    for (int r = 0; r < cells; row += ++r) {
        const std::int32_t* const next = row + r + 1;
        for (int c = 0; c <= r; ++c) {
            if (c < r) widen(out, row[c], row[c + 1]);
            widen(out, row[c], next[c]);
            main_diagonal(r, c) ? widen(out, row[c], next[c + 1]) : widen(out, row[c + 1], next[c]);
        }
    }
    for (int c = 0; c < cells; ++c) widen(out, row[c], row[c + 1]);
    return out;
}

// As many columns as lanes, row by row. Differences are right where they fit 31 bits.
struct Strip {
    using D32 = hn::ScalableTag<std::int32_t>;
    using V32 = hn::Vec<D32>;
    using Mask = hn::Mask<D32>;

    V32 least, greatest, most = hn::Zero(D32());
    V32 p, t;  // the row's heights, and those to the right

    HWY_INLINE Strip(std::int32_t start, const std::int32_t* row)
        : least(hn::Set(D32(), start)),
          greatest(least),
          p(hn::LoadU(D32(), row)),
          t(hn::LoadU(D32(), row + 1)) {}

    static HWY_INLINE V32 apart(V32 x, V32 y) { return hn::Abs(hn::Sub(x, y)); }

    // On to the next row. other: where the cell's diagonal is not its main one.
    HWY_INLINE void step(const std::int32_t* next, Mask other) {
        const D32 d;
        const V32 q = hn::LoadU(d, next), s = hn::LoadU(d, next + 1);
        least = hn::Min(least, p);
        greatest = hn::Max(greatest, p);
        most = hn::Max(most, apart(p, t));
        most = hn::Max(most, apart(p, q));
        most = hn::Max(most, apart(hn::IfThenElse(other, t, p), hn::IfThenElse(other, q, s)));
        p = q;
        t = s;
    }
    // The same where the row ends after the lane `end`.
    HWY_INLINE void partial_step(const std::int32_t* next, Mask other, int end) {
        const D32 d;
        const V32 lane = hn::Iota(d, 0), last = hn::Set(d, end);
        const Mask inside = hn::Lt(lane, last), on = hn::Or(inside, hn::Eq(lane, last));
        const V32 q = hn::LoadU(d, next), s = hn::LoadU(d, next + 1);
        least = hn::Min(least, hn::IfThenElse(on, p, least));
        greatest = hn::Max(greatest, hn::IfThenElse(on, p, greatest));
        most = hn::Max(most, hn::IfThenElseZero(inside, apart(p, t)));
        most = hn::Max(most, hn::IfThenElseZero(on, apart(p, q)));
        const V32 across = apart(hn::IfThenElse(other, t, p), hn::IfThenElse(other, q, s));
        most = hn::Max(most, hn::IfThenElseZero(on, across));
        p = q;
        t = s;
    }
    // The half's last row.
    HWY_INLINE void end(WholeRange& out) {
        const D32 d;
        least = hn::Min(least, p);
        greatest = hn::Max(greatest, p);
        most = hn::Max(most, apart(p, t));
        out.least = std::min(out.least, hn::GetLane(hn::MinOfLanes(d, least)));
        out.greatest = std::max(out.greatest, hn::GetLane(hn::MaxOfLanes(d, greatest)));
        out.in_triangle =
            std::max(out.in_triangle, static_cast<std::uint32_t>(hn::GetLane(hn::MaxOfLanes(d, most))));
    }
};

// Lanes beyond a row's end hold heights of the next rows, which exist: the strip's last row is full.
void Range32(const std::int32_t* heights, int cells, WholeRange& result) {
    const Strip::D32 d;
    const int lanes = static_cast<int>(hn::Lanes(d));
    if (lanes == 1 || cells % lanes != 0) {
        result = plain_range(heights, cells);
        return;
    }
    const std::int32_t corner = heights[half_vertex_count(cells) - 1];
    WholeRange out{corner, corner, 0};
    // Strips start at even columns, so that a row's first diagonal tells by its parity.
    const auto odd_lane = hn::Ne(hn::And(hn::Iota(d, 0), hn::Set(d, 1)), hn::Zero(d)),
               even_lane = hn::Not(odd_lane);
    for (int c = 0; c < cells; c += lanes) {
        const std::int32_t* row = heights + half_vertex_index(c, c);
        Strip strip(corner, row);
        int r = c;
        for (; r < c + lanes; ++r) {
            row += r + 1;
            strip.partial_step(row, r % 2 == 0 ? odd_lane : even_lane, r - c);
        }
        for (; r < cells; r += 2) {
            strip.step(row += r + 1, odd_lane);
            strip.step(row += r + 2, even_lane);
        }
        strip.end(out);
    }
    result = std::int64_t{out.greatest} - out.least <= std::numeric_limits<std::int32_t>::max()
                 ? out
                 : plain_range(heights, cells);
}

HWY_INLINE void transpose_one(const std::int32_t* half, int i, int j, int n, std::int32_t* out) {
    out[i * n + j] = half[half_vertex_index(j, i)];
}

#if HWY_TARGET != HWY_SCALAR
// Rows j to j + 3 of the half, its columns i to i + 3.
HWY_INLINE void transpose_square(const std::int32_t* half, int i, int j, int n, std::int32_t* out) {
    const hn::CappedTag<std::int32_t, 4> d;
    const hn::RepartitionToWide<decltype(d)> wide;
    const auto load = [&](int k) HWY_ATTR { return hn::LoadU(d, half + half_vertex_index(j + k, 0) + i); };
    const auto store = [&](int k, auto pairs)
                           HWY_ATTR { hn::StoreU(hn::BitCast(d, pairs), d, out + (i + k) * n + j); };
    const auto a = load(0), b = load(1), c = load(2), e = load(3);
    const auto ab = hn::BitCast(wide, hn::InterleaveLower(d, a, b)),
               ce = hn::BitCast(wide, hn::InterleaveLower(d, c, e)),
               ab_up = hn::BitCast(wide, hn::InterleaveUpper(d, a, b)),
               ce_up = hn::BitCast(wide, hn::InterleaveUpper(d, c, e));
    store(0, hn::InterleaveLower(wide, ab, ce));
    store(1, hn::InterleaveUpper(wide, ab, ce));
    store(2, hn::InterleaveLower(wide, ab_up, ce_up));
    store(3, hn::InterleaveUpper(wide, ab_up, ce_up));
}
#endif

// Squares of four by four, the rest one by one.
void Transpose32(const std::int32_t* half, int cells, std::int32_t* out) {
    const int n = cells + 1;
    for (int j = 0; j < n; j += 4) {
        const int rows = std::min(4, n - j);
        int i = 0;
#if HWY_TARGET != HWY_SCALAR
        if (rows == 4)
            for (; i + 4 <= j + 1; i += 4) transpose_square(half, i, j, n, out);
#endif
        for (int k = 0; k < rows; ++k)
            for (int rest = i; rest <= j + k; ++rest) transpose_one(half, rest, j + k, n, out);
    }
}

// Every `step`th value from `from` on.
struct Strided {
    const std::int32_t* from;
    std::ptrdiff_t step;
};

// out[k]: values of `even` and `odd` in turn.
HWY_INLINE void take_turns_plainly(Strided even, Strided odd, std::ptrdiff_t count, std::int32_t* out) {
    for (std::ptrdiff_t k = 0; k < count; ++k)
        out[k] = k % 2 == 0 ? even.from[k / 2 * even.step] : odd.from[k / 2 * odd.step];
}

#if HWY_TARGET == HWY_SCALAR || HWY_MAX_BYTES < 32
HWY_INLINE void take_turns(Strided even, Strided odd, std::ptrdiff_t count, std::int32_t* out) {
    take_turns_plainly(even, odd, count, out);
}
#else
// Sixteen at a time by two gathers; the last sixteen may overlap those before.
HWY_INLINE void take_turns(Strided even, Strided odd, std::ptrdiff_t count, std::int32_t* out) {
    const hn::CappedTag<std::int32_t, 8> d;
    const auto both = 2 * static_cast<std::ptrdiff_t>(hn::Lanes(d));
    if (count < both) return take_turns_plainly(even, odd, count, out);
    const auto even_places = hn::Mul(hn::Iota(d, 0), hn::Set(d, static_cast<std::int32_t>(even.step))),
               odd_places = hn::Mul(hn::Iota(d, 0), hn::Set(d, static_cast<std::int32_t>(odd.step)));
    const auto evens = [&](std::ptrdiff_t k)
                           HWY_ATTR { return hn::GatherIndex(d, even.from + k * even.step, even_places); };
    const auto odds = [&](std::ptrdiff_t k)
                          HWY_ATTR { return hn::GatherIndex(d, odd.from + k * odd.step, odd_places); };
    std::ptrdiff_t k = 0;
    for (; k + both <= count; k += both) hn::StoreInterleaved2(evens(k / 2), odds(k / 2), d, out + k);
    if (k == count) return;
    k = count - both;
    if (k % 2 == 0)
        hn::StoreInterleaved2(evens(k / 2), odds(k / 2), d, out + k);
    else
        hn::StoreInterleaved2(odds(k / 2), evens(k / 2 + 1), d, out + k);
}
#endif

// Along a row of the child p and q change by one, so V and C take turns, each along a diagonal of its matrix.
void GatherRows(const std::int32_t* v, const std::int32_t* c, const RowMap& m, int cells, std::int32_t* out) {
    const std::ptrdiff_t n = cells + 1, v_step = m.p_along * n + m.q_along,
                         c_step = m.p_along * cells + m.q_along;
    const auto from = [&](std::ptrdiff_t p, std::ptrdiff_t q) -> Strided {
        if ((p & 1) == 0) return {v + (p >> 1) * n + (q >> 1), v_step};
        return {c + (p >> 1) * cells + (q >> 1), c_step};
    };
    for (int r = 0; r <= cells; out += ++r) {
        const std::ptrdiff_t p = m.p0 + r * m.p_row, q = m.q0 + r * m.q_row;
        const Strided first = from(p, q);
        // A second diagonal that no value is taken of need not lie inside.
        take_turns(first, r == 0 ? first : from(p + m.p_along, q + m.q_along), r + 1, out);
    }
}

}  // namespace carat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat {

HWY_EXPORT(NormalsAndGround);
HWY_EXPORT(Range32);
HWY_EXPORT(Transpose32);
HWY_EXPORT(GatherRows);

void normals_and_ground(const Ellipsoid& body, const Places& w, Places& normals, Places& ground) {
    HWY_DYNAMIC_DISPATCH(NormalsAndGround)(body.a() * body.a(), body.b() * body.b(), w, normals, ground);
}

WholeRange whole_range(std::span<const std::int32_t> heights, int cells) {
    assert(heights.size() == half_vertex_count(cells));
    WholeRange out;
    HWY_DYNAMIC_DISPATCH(Range32)(heights.data(), cells, out);
    return out;
}

void transpose_half(std::span<const std::int32_t> half, int cells, std::int32_t* out) {
    assert(half.size() == half_vertex_count(cells));
    HWY_DYNAMIC_DISPATCH(Transpose32)(half.data(), cells, out);
}

void gather_rows(const std::int32_t* v, const std::int32_t* c, const RowMap& map, int cells,
                 std::int32_t* out) {
    HWY_DYNAMIC_DISPATCH(GatherRows)(v, c, map, cells, out);
}

}  // namespace carat
#endif
