#include "patch_kernel.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstring>

#include "carat/globe/diamond.hpp"
#include "carat/globe/patch.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "patch_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;
using F = hn::Rebind<float, D>;
using I32 = hn::Rebind<std::int32_t, D>;
using I64 = hn::Rebind<std::int64_t, D>;
using U64 = hn::Rebind<std::uint64_t, D>;
using U32 = hn::Rebind<std::uint32_t, D>;

// Operators for the formula, which is written once for scalars and vectors.
struct Lanes {
    V v;
};
HWY_INLINE Lanes operator+(Lanes l, Lanes r) { return {hn::Add(l.v, r.v)}; }
HWY_INLINE Lanes operator-(Lanes l, Lanes r) { return {hn::Sub(l.v, r.v)}; }
HWY_INLINE Lanes operator*(Lanes l, Lanes r) { return {hn::Mul(l.v, r.v)}; }
HWY_INLINE Lanes operator/(Lanes l, Lanes r) { return {hn::Div(l.v, r.v)}; }
HWY_INLINE Lanes root(Lanes x) { return {hn::Sqrt(x.v)}; }
HWY_INLINE Lanes constant(double x, Lanes) { return {hn::Set(D(), x)}; }
// Halves away from zero. x - trunc(x) is exact.
HWY_INLINE Lanes round_away(Lanes x) {
    const V whole = hn::Trunc(x.v), rest = hn::Abs(hn::Sub(x.v, whole));
    const V one = hn::CopySign(hn::Set(D(), 1.0), x.v);
    return {hn::IfThenElse(hn::Ge(rest, hn::Set(D(), 0.5)), hn::Add(whole, one), whole)};
}

#define VERTEX_FORMULA HWY_INLINE
#include "vertex_formula.inc"
#undef VERTEX_FORMULA

void Tangents(double* x, std::size_t count) {
    const D d;
    for (std::size_t k = 0; k < count; k += hn::Lanes(d)) {
        const V v = hn::LoadU(d, x + k);
        const V t = tangent(Lanes{v}).v;
        hn::StoreU(hn::IfThenElse(hn::Eq(hn::Abs(v), hn::Set(d, 1.0)), v, t), d, x + k);
    }
}

HWY_INLINE V load_heights(const std::int32_t* p) { return hn::PromoteTo(D(), hn::LoadU(I32(), p)); }
HWY_INLINE V load_heights(const std::int64_t* p) { return hn::ConvertTo(D(), hn::LoadU(I64(), p)); }

// Offsets of three rows of vertices at a time, whole numbers as doubles; the row before and after each row
// and the vertex before its first may be read.
constexpr int kMargin = 8, kPitch = kMargin + 129 + 31;
struct Row {
    alignas(64) double x[kPitch], y[kPitch], z[kPitch];
    alignas(64) float height[kPitch];
};

class Builder {
  public:
    Builder(const PatchShape& shape, PatchVertex* vertices) : s_(shape), vertices_(vertices) {}

    template <class Height>
    void run(const Height* heights, std::size_t count) {
        std::memset(rows_, 0, sizeof(rows_));
        for (int r = 0; r <= s_.cells; ++r) {
            positions(r, heights, count);
            if (r > 0) emit(r - 1);
        }
        emit(s_.cells);
        borrow_border_normals();
    }

  private:
    Row& row(int r) { return rows_[(r + 3) % 3]; }

    HWY_INLINE Lanes tangent(int axis, int r, int c) const {
        const TangentTable& table = *s_.tangents[static_cast<std::size_t>(axis)];
        return {table.along_row() ? hn::LoadU(D(), table.at(r) + c) : hn::Set(D(), *table.at(r))};
    }

    template <class Height>
    void positions(int r, const Height* heights, std::size_t count) {
        const D d;
        const int lanes = static_cast<int>(hn::Lanes(d));
        Row& out = row(r);
        const std::size_t first = half_vertex_index(r, 0);
        const Body<Lanes> body{{hn::Set(d, s_.a2)}, {hn::Set(d, s_.b2)}, {hn::Set(d, s_.per_unit)}};
        for (int c = 0; c <= r; c += lanes) {
            // The last vector may reach beyond the last height.
            const std::size_t k = first + static_cast<std::size_t>(c);
            V h;
            if (k + static_cast<std::size_t>(lanes) <= count) {
                h = load_heights(heights + k);
            } else {
                Height rest[64] = {};
                std::copy(heights + k, heights + count, rest);
                h = load_heights(rest);
            }
            h = hn::Mul(h, hn::Set(d, s_.metres));
            const std::array<Lanes, 3> p =
                position(body, tangent(0, r, c), tangent(1, r, c), tangent(2, r, c), Lanes{h});
            hn::StoreU(hn::Sub(round_away(p[0]).v, hn::Set(d, static_cast<double>(s_.anchor[0]))), d,
                       out.x + kMargin + c);
            hn::StoreU(hn::Sub(round_away(p[1]).v, hn::Set(d, static_cast<double>(s_.anchor[1]))), d,
                       out.y + kMargin + c);
            hn::StoreU(hn::Sub(round_away(p[2]).v, hn::Set(d, static_cast<double>(s_.anchor[2]))), d,
                       out.z + kMargin + c);
            hn::StoreU(hn::DemoteTo(F(), h), F(), out.height + kMargin + c);
        }
    }

    // Row r, the rows around it being there. Vectors that reach beyond a row's end are overwritten by the
    // next.
    void emit(int r) {
        const int lanes = static_cast<int>(hn::Lanes(D()));
        PatchVertex* const out = vertices_ + half_vertex_index(r, 0);
        const PatchVertex* const end = vertices_ + half_vertex_count(s_.cells);
        for (int c = 0; c <= r; c += lanes) {
            if (out + c + lanes <= end) {
                emit(r, c, out + c);
            } else {
                PatchVertex rest[64];
                emit(r, c, rest);
                std::copy(rest, rest + (end - (out + c)), out + c);
            }
        }
    }

    HWY_INLINE void emit(int r, int c, PatchVertex* out) {
        const I64 i64;
        const U64 u64;
        const Row& mid = row(r);
        const int k = kMargin + c;
        const auto x = hn::ConvertTo(i64, hn::LoadU(D(), mid.x + k));
        const auto y = hn::ConvertTo(i64, hn::LoadU(D(), mid.y + k));
        const auto z = hn::ConvertTo(i64, hn::LoadU(D(), mid.z + k));
        const auto normal = hn::PromoteTo(u64, hn::BitCast(U32(), normals(r, k)));
        const auto height = hn::PromoteTo(u64, hn::BitCast(U32(), hn::LoadU(F(), mid.height + k)));
        const auto last = hn::Or(normal, hn::ShiftLeft<32>(height));
        static_assert(offsetof(PatchVertex, normal) == 24 && offsetof(PatchVertex, height) == 28);
        static_assert(std::endian::native == std::endian::little);
        hn::StoreInterleaved4(hn::BitCast(u64, x), hn::BitCast(u64, y), hn::BitCast(u64, z), last, u64,
                              reinterpret_cast<std::uint64_t*>(out));
    }

    // Octahedral, two int16 a lane.
    HWY_INLINE hn::Vec<I32> normals(int r, int k) {
        const D d;
        const F f;
        const Row &up = row(r - 1), &mid = row(r), &down = row(r + 1);
        const auto along = [&](const double* later, const double* earlier) {
            return hn::DemoteTo(f, hn::Sub(hn::LoadU(d, later), hn::LoadU(d, earlier)));
        };
        const auto rx = along(down.x + k, up.x + k), ry = along(down.y + k, up.y + k),
                   rz = along(down.z + k, up.z + k);
        const auto cx = along(mid.x + k + 1, mid.x + k - 1), cy = along(mid.y + k + 1, mid.y + k - 1),
                   cz = along(mid.z + k + 1, mid.z + k - 1);
        auto x = hn::Sub(hn::Mul(ry, cz), hn::Mul(rz, cy));
        auto y = hn::Sub(hn::Mul(rz, cx), hn::Mul(rx, cz));
        auto z = hn::Sub(hn::Mul(rx, cy), hn::Mul(ry, cx));
        if (s_.side == 1) {  // r is j there: the other handedness
            x = hn::Neg(x);
            y = hn::Neg(y);
            z = hn::Neg(z);
        }
        auto sum = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
        // Heights beyond any planet may fold a ring to nothing: its normal points outwards all the same.
        const auto flat = hn::Not(hn::Gt(sum, hn::Zero(f)));
        if (HWY_UNLIKELY(!hn::AllFalse(f, flat))) {
            const auto place = [&](const double* p, std::size_t axis) {
                return hn::DemoteTo(
                    f, hn::Add(hn::LoadU(d, p), hn::Set(d, static_cast<double>(s_.anchor[axis]))));
            };
            x = hn::IfThenElse(flat, place(mid.x + k, 0), x);
            y = hn::IfThenElse(flat, place(mid.y + k, 1), y);
            z = hn::IfThenElse(flat, place(mid.z + k, 2), z);
            sum = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
        }
        const auto one = hn::Set(f, 1.0f), share = hn::Div(one, sum);
        auto u = hn::Mul(x, share), v = hn::Mul(y, share);
        const auto lower = hn::Lt(z, hn::Zero(f));
        const auto folded_u = hn::CopySign(hn::Sub(one, hn::Abs(v)), u);
        const auto folded_v = hn::CopySign(hn::Sub(one, hn::Abs(u)), v);
        const auto most = hn::Set(f, 32767.0f);
        const auto iu = hn::NearestInt(hn::Mul(hn::IfThenElse(lower, folded_u, u), most));
        const auto iv = hn::NearestInt(hn::Mul(hn::IfThenElse(lower, folded_v, v), most));
        return hn::Or(hn::And(iu, hn::Set(I32(), 0xFFFF)), hn::ShiftLeft<16>(iv));
    }

    void borrow_border_normals() {
        const int n = s_.cells;
        const auto borrow = [this, n](int r, int c) {
            const int inner_r = std::clamp(r, 2, n - 1), inner_c = std::clamp(c, 1, inner_r - 1);
            vertices_[half_vertex_index(r, c)].normal = vertices_[half_vertex_index(inner_r, inner_c)].normal;
        };
        for (int r = 0; r < n; ++r) {
            borrow(r, 0);
            borrow(r, r);
        }
        for (int c = 0; c <= n; ++c) borrow(n, c);
    }

    const PatchShape& s_;
    PatchVertex* vertices_;
    Row rows_[3];
};

void Build32(const PatchShape& shape, const std::int32_t* heights, std::size_t count, PatchVertex* out) {
    Builder(shape, out).run(heights, count);
}
void Build64(const PatchShape& shape, const std::int64_t* heights, std::size_t count, PatchVertex* out) {
    Builder(shape, out).run(heights, count);
}

void Range32(const std::int32_t* heights, int cells, WholeRange& out) {
    const hn::ScalableTag<std::int32_t> d;
    const hn::RebindToUnsigned<decltype(d)> u;
    const int lanes = static_cast<int>(hn::Lanes(d));
    auto least = hn::Set(d, heights[0]), greatest = least;
    auto range = hn::Zero(u);
    const auto odd = hn::Ne(hn::And(hn::Iota(d, 0), hn::Set(d, 1)), hn::Zero(d));
    const auto widen = [&](auto x, auto y, auto z) HWY_ATTR {
        const auto low = hn::Min(hn::Min(x, y), z), high = hn::Max(hn::Max(x, y), z);
        least = hn::Min(least, low);
        greatest = hn::Max(greatest, high);
        // Exact in 32 bits without sign.
        range = hn::Max(range, hn::Sub(hn::BitCast(u, high), hn::BitCast(u, low)));
    };
    const std::int32_t* row = heights;
    std::int32_t low = heights[0], high = heights[0];
    std::uint32_t most = 0;
    const auto widen_one = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
        const std::int32_t l = std::min({x, y, z}), h = std::max({x, y, z});
        low = std::min(low, l);
        high = std::max(high, h);
        most = std::max(most, static_cast<std::uint32_t>(h) - static_cast<std::uint32_t>(l));
    };
    for (int r = 0; r < cells; row += ++r) {
        const std::int32_t* const next = row + r + 1;
        int c = 0;
        // Main diagonals where r and c are both odd or both even; c is even here.
        const auto main = (r & 1) == 0 ? hn::Not(odd) : odd;
        for (; c + lanes <= r; c += lanes) {
            const auto p = hn::LoadU(d, row + c), t = hn::LoadU(d, row + c + 1), q = hn::LoadU(d, next + c),
                       s = hn::LoadU(d, next + c + 1);
            widen(p, q, hn::IfThenElse(main, s, t));
            widen(hn::IfThenElse(main, p, q), s, t);
        }
        for (; c < r; ++c) {
            const bool m = main_diagonal(r, c);
            widen_one(row[c], next[c], m ? next[c + 1] : row[c + 1]);
            widen_one(m ? row[c] : next[c], next[c + 1], row[c + 1]);
        }
        widen_one(row[r], next[r], next[r + 1]);
    }
    out.least = std::min(low, hn::GetLane(hn::MinOfLanes(d, least)));
    out.greatest = std::max(high, hn::GetLane(hn::MaxOfLanes(d, greatest)));
    out.in_triangle = std::max(most, hn::GetLane(hn::MaxOfLanes(u, range)));
}

}  // namespace carat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat {

HWY_EXPORT(Tangents);
HWY_EXPORT(Build32);
HWY_EXPORT(Build64);
HWY_EXPORT(Range32);

void tangents_in_place(std::span<double> tangents) {
    assert(tangents.size() % 16 == 0);
    HWY_DYNAMIC_DISPATCH(Tangents)(tangents.data(), tangents.size());
}

// The coordinate is origin + i u + j v with u and v each 0 or +-step, so it takes few values. Along a row it
// rises by one step, or falls: then the table is in descending order.
TangentTable::TangentTable(const Half& half, int axis, int cells) {
    const HalfFrame f = half_frame(half, cells);
    const auto sign = [](std::int64_t x) { return x > 0 ? 1 : x < 0 ? -1 : 0; };
    const std::int64_t u = f.u[axis], v = f.v[axis], step = std::max(std::abs(u), std::abs(v));
    const int along_r = sign(half.side == 0 ? u : v), along_c = sign(half.side == 0 ? v : u);
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
    tangents_in_place({tangents_.data(), padded});
}

void build_vertices(const PatchShape& shape, std::span<const std::int32_t> heights, PatchVertex* vertices) {
    HWY_DYNAMIC_DISPATCH(Build32)(shape, heights.data(), heights.size(), vertices);
}
void build_vertices(const PatchShape& shape, std::span<const std::int64_t> heights, PatchVertex* vertices) {
    HWY_DYNAMIC_DISPATCH(Build64)(shape, heights.data(), heights.size(), vertices);
}

WholeRange whole_range(std::span<const std::int32_t> heights, int cells) {
    assert(heights.size() == half_vertex_count(cells));
    WholeRange out;
    HWY_DYNAMIC_DISPATCH(Range32)(heights.data(), cells, out);
    return out;
}

}  // namespace carat
#endif
