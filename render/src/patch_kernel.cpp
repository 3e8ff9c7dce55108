#include "patch_kernel.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstddef>

#include "carat/globe/diamond.hpp"
#include "carat/globe/patch.hpp"
#include "whole_units.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "patch_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#include "vertex_lanes.inc"

using I64 = hn::Rebind<std::int64_t, D>;
using U64 = hn::Rebind<std::uint64_t, D>;
// As many lanes as D has, and full vectors.
using HalfF = hn::Rebind<float, D>;
using HalfI32 = hn::Rebind<std::int32_t, D>;
using HalfU32 = hn::Rebind<std::uint32_t, D>;
using F = hn::ScalableTag<float>;
using I32 = hn::ScalableTag<std::int32_t>;

HWY_INLINE V load_heights(const std::int32_t* p) { return hn::PromoteTo(D(), hn::LoadU(HalfI32(), p)); }
HWY_INLINE V load_heights(const std::int64_t* p) { return hn::ConvertTo(D(), hn::LoadU(I64(), p)); }

// Some rows of vertices at a time: offsets in length units, rounded to vertices and not rounded for normals.
// The row before and after each row and the vertex before its first may be read. Whatever lies beyond a row's
// end is left from other rows, and comes to nothing.
constexpr int kMargin = 16, kPitch = kMargin + 129 + 47;
// Rows made together, and kept: these and the two before them.
constexpr int kBlock = 8, kRing = 16;
struct Row {
    alignas(64) std::int64_t x[kPitch], y[kPitch], z[kPitch];
    alignas(64) float fx[kPitch], fy[kPitch], fz[kPitch], height[kPitch];
};
// Of the first vertex of each row, then of the last of each: tangents and then places in length units.
struct Border {
    double place[3][2 * 129 + 30], height[2 * 129 + 30];
};
struct Scratch {
    Row rows[kRing];
    Border border{};
    alignas(64) std::int32_t normals[kPitch];
};

class Builder {
  public:
    Builder(const PatchShape& shape, PatchVertex* vertices, Scratch& scratch)
        : s_(shape), vertices_(vertices), scratch_(scratch) {
        for (std::size_t k = 0; k < 3; ++k) {
            anchor_[k] = static_cast<double>(shape.anchor[k]);
            // Modulo 2^64.
            anchor_bits_[k] = static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(kWholeInMantissa) +
                                                        static_cast<std::uint64_t>(shape.anchor[k]));
        }
    }

    template <class Height>
    void run(const Height* heights, std::size_t count) {
        for (int first = 0, done = 0; first <= s_.cells; first += kBlock) {
            const int end = std::min(first + kBlock, s_.cells + 1);
            if (s_.fit != nullptr && first < s_.cells)
                fitted_rows(first, end, heights);
            else
                for (int r = first; r < end; ++r) exact_row(r, heights, count);
            for (; done < (end > s_.cells ? end : end - 1); ++done) emit(done);
        }
        if (s_.fit != nullptr) border(heights);
        borrow_border_normals();
    }

  private:
    Row& row(int r) { return scratch_.rows[static_cast<unsigned>(r + kRing) % kRing]; }

    // The tangents of a row.
    struct Tangent {
        const double* at;
        bool along_row;
        HWY_INLINE Lanes operator()(int c) const {
            return {along_row ? hn::LoadU(D(), at + c) : hn::Set(D(), *at)};
        }
    };
    Tangent tangent(std::size_t axis, int r) const {
        return {s_.tangents[axis]->at(r), s_.tangents[axis]->along_row()};
    }

    template <class Height>
    void exact_row(int r, const Height* heights, std::size_t count) {
        const D d;
        const int lanes = static_cast<int>(hn::Lanes(d));
        Row& out = row(r);
        const std::size_t first = half_vertex_index(r, 0);
        const Body<Lanes> body = this->body();
        const V metres = hn::Set(d, s_.metres);
        const Tangent wx = tangent(0, r), wy = tangent(1, r), wz = tangent(2, r);
        const Axis x(*this, 0), y(*this, 1), z(*this, 2);
        for (int c = 0; c <= r; c += lanes) {
            // The last vector may reach beyond the last height.
            const std::size_t k = first + static_cast<std::size_t>(c);
            V h;
            if (HWY_LIKELY(k + static_cast<std::size_t>(lanes) <= count)) {
                h = load_heights(heights + k);
            } else {
                Height rest[64] = {};
                std::copy(heights + k, heights + count, rest);
                h = load_heights(rest);
            }
            h = hn::Mul(h, metres);
            const std::array<Lanes, 3> p = position(body, wx(c), wy(c), wz(c), Lanes{h});
            const int at = kMargin + c;
            x.store(p[0].v, out.x + at, out.fx + at);
            y.store(p[1].v, out.y + at, out.fy + at);
            z.store(p[2].v, out.z + at, out.fz + at);
            hn::StoreU(hn::DemoteTo(HalfF(), h), HalfF(), out.height + at);
        }
    }

    // The first and the last vertex of every row but the last go where the formula has them: neighbours share
    // them. Normals keep the fitted place, which differs by less than floats do.
    template <class Height>
    void border(const Height* heights) {
        const D d;
        Border& b = scratch_.border;
        const int n = s_.cells + 1;
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (int r = 0; r < n; ++r) {
                b.place[axis][r] = s_.tangents[axis]->value(r, 0);
                b.place[axis][n + r] = s_.tangents[axis]->value(r, r);
            }
        for (int r = 0; r < n; ++r) {
            b.height[r] = static_cast<double>(heights[half_vertex_index(r, 0)]);
            b.height[n + r] = static_cast<double>(heights[half_vertex_index(r, r)]);
        }
        const Body<Lanes> body = this->body();
        const V metres = hn::Set(d, s_.metres);
        for (int k = 0; k < 2 * n; k += static_cast<int>(hn::Lanes(d))) {
            const auto w = [&](std::size_t axis) HWY_ATTR { return Lanes{hn::LoadU(d, b.place[axis] + k)}; };
            const V h = hn::Mul(hn::LoadU(d, b.height + k), metres);
            const std::array<Lanes, 3> p = position(body, w(0), w(1), w(2), Lanes{h});
            for (std::size_t axis = 0; axis < 3; ++axis) hn::StoreU(p[axis].v, d, b.place[axis] + k);
        }
        for (int r = 0; r < s_.cells; ++r) {
            move(r, vertices_[half_vertex_index(r, 0)]);
            move(n + r, vertices_[half_vertex_index(r, r)]);
        }
    }

    HWY_INLINE void move(int k, PatchVertex& vertex) const {
        for (std::size_t axis = 0; axis < 3; ++axis)
            vertex.offset[axis] = nearest_whole(scratch_.border.place[axis][k]) - s_.anchor[axis];
    }

    Body<Lanes> body() const {
        const D d;
        return {{hn::Set(d, s_.a2)}, {hn::Set(d, s_.b2)}, {hn::Set(d, s_.per_unit)}};
    }

    template <class Height>
    void fitted_rows(int first, int end, const Height* heights) {
        switch (s_.fit->coefficients) {
            case 4:
                fitted_rows<4>(first, end, heights);
                break;
            case 5:
                fitted_rows<5>(first, end, heights);
                break;
            case 6:
                fitted_rows<6>(first, end, heights);
                break;
            default:
                fitted_rows<8>(first, end, heights);
        }
    }

    // No vector reaches beyond the last height: the last row is not among these.
    template <std::size_t kCount, class Height>
    void fitted_rows(int first, int end, const Height* heights) {
        const D d;
        const V flattening = hn::Set(d, s_.fit->flattening), metres = hn::Set(d, s_.metres);
        const Axis x(*this, 0), y(*this, 1), z(*this, 2);
        const double* const rows = s_.fit->rows.data();
        Row* const ring = scratch_.rows;
        for (int c = 0; c < end; c += static_cast<int>(hn::Lanes(d))) {
            const Polynomial<kCount> surface(s_.fit->surface, c), normal(s_.fit->normal, c);
            const int at = kMargin + c;
            const Tangents tx(*s_.tangents[0], c), ty(*s_.tangents[1], c), tz(*s_.tangents[2], c);
            int r = std::max(first, c);
            const Height* height = heights + half_vertex_index(r, 0) + c;
            for (; r < end; height += ++r) {
                const V h = hn::Mul(load_heights(height), metres);
                const V rho = hn::Set(d, rows[r]);
                const V a = surface(rho), raised = hn::Mul(h, normal(rho)), across = hn::Add(a, raised);
                Row& out = ring[static_cast<unsigned>(r) % kRing];
                x.store(hn::Mul(tx.row(r), across), out.x + at, out.fx + at);
                y.store(hn::Mul(ty.row(r), across), out.y + at, out.fy + at);
                z.store(hn::Mul(tz.row(r), hn::Add(hn::Mul(a, flattening), raised)), out.z + at, out.fz + at);
                hn::StoreU(hn::DemoteTo(HalfF(), h), HalfF(), out.height + at);
            }
        }
    }

    // Of some columns, row by row.
    struct Tangents {
        const double* first;
        std::ptrdiff_t per_row;
        bool along_row;
        HWY_INLINE Tangents(const TangentTable& table, int c)
            : first(table.at(0) + (table.along_row() ? c : 0)),
              per_row(table.at(1) - table.at(0)),
              along_row(table.along_row()) {}
        HWY_INLINE V row(int r) const {
            const double* const at = first + r * per_row;
            return along_row ? hn::LoadU(D(), at) : hn::Set(D(), *at);
        }
    };

    // Of the rows, in a vector of columns.
    template <std::size_t kCount>
    struct Polynomial {
        V coefficient[kCount];
        HWY_INLINE Polynomial(const PositionFit::Coefficients& columns, int c) {
            for (std::size_t k = 0; k < kCount; ++k) coefficient[k] = hn::LoadU(D(), columns[k].data() + c);
        }
        HWY_INLINE V operator()(V x) const {
            V sum = coefficient[kCount - 1];
            for (std::size_t k = kCount - 1; k-- > 0;) sum = hn::Add(hn::Mul(sum, x), coefficient[k]);
            return sum;
        }
    };

    struct Axis {
        V anchor;
        hn::Vec<I64> anchor_bits;  // of the anchor + kWholeInMantissa, modulo 2^64
        HWY_INLINE Axis(const Builder& b, std::size_t axis)
            : anchor(hn::Set(D(), b.anchor_[axis])), anchor_bits(hn::Set(I64(), b.anchor_bits_[axis])) {}

        // As nearest_whole(), and the anchor subtracted in one.
        HWY_INLINE void store(V place, std::int64_t* whole, float* real) const {
            const auto bits = hn::BitCast(I64(), hn::Add(place, hn::Set(D(), kWholeInMantissa)));
            hn::StoreU(hn::Sub(bits, anchor_bits), I64(), whole);
            hn::StoreU(hn::DemoteTo(HalfF(), hn::Sub(place, anchor)), HalfF(), real);
        }
    };

    // Row r, the rows around it being there. Vectors that reach beyond a row's end are overwritten by the
    // next; they start where no store crosses a cache line.
    HWY_INLINE void emit(int r) {
        normals(r);
        const int lanes = static_cast<int>(hn::Lanes(D()));
        PatchVertex* const out = vertices_ + half_vertex_index(r, 0);
        const PatchVertex* const end = vertices_ + half_vertex_count(s_.cells);
        const Row& mid = row(r);
        const int odd = static_cast<int>(half_vertex_index(r, 0) % 2);
        if (odd != 0) {
            out->offset = {mid.x[kMargin], mid.y[kMargin], mid.z[kMargin]};
            out->height = mid.height[kMargin];
        }
        for (int c = odd; c <= r; c += lanes) {
            if (HWY_LIKELY(out + c + lanes <= end)) {
                emit(mid, kMargin + c, out + c);
            } else {
                PatchVertex rest[64];
                emit(mid, kMargin + c, rest);
                std::copy(rest, rest + (end - (out + c)), out + c);
            }
        }
    }

    HWY_INLINE void emit(const Row& mid, int k, PatchVertex* out) const {
        const I64 i64;
        const U64 u64;
        const auto x = hn::LoadU(i64, mid.x + k), y = hn::LoadU(i64, mid.y + k),
                   z = hn::LoadU(i64, mid.z + k);
        const auto normal =
            hn::PromoteTo(u64, hn::BitCast(HalfU32(), hn::LoadU(HalfI32(), scratch_.normals + k)));
        const auto height = hn::PromoteTo(u64, hn::BitCast(HalfU32(), hn::LoadU(HalfF(), mid.height + k)));
        const auto last = hn::Or(normal, hn::ShiftLeft<32>(height));
        static_assert(offsetof(PatchVertex, normal) == 24 && offsetof(PatchVertex, height) == 28);
        static_assert(std::endian::native == std::endian::little);
        hn::StoreInterleaved4(hn::BitCast(u64, x), hn::BitCast(u64, y), hn::BitCast(u64, z), last, u64,
                              reinterpret_cast<std::uint64_t*>(out));
    }

    // Octahedral, two int16 a lane.
    void normals(int r) {
        // Where side is 1, r is j: the other handedness.
        const Row &mid = row(r), &less = row(s_.side == 1 ? r + 1 : r - 1),
                  &more = row(s_.side == 1 ? r - 1 : r + 1);
        const int lanes = static_cast<int>(hn::Lanes(F()));
        for (int k = kMargin; k <= kMargin + r; k += lanes)
            hn::StoreU(normal(less, mid, more, k), I32(), scratch_.normals + k);
    }

    HWY_INLINE hn::Vec<I32> normal(const Row& less, const Row& mid, const Row& more, int k) const {
        const F f;
        const auto along = [&](const float* later, const float* earlier)
                               HWY_ATTR { return hn::Sub(hn::LoadU(f, later), hn::LoadU(f, earlier)); };
        const auto rx = along(more.fx + k, less.fx + k), ry = along(more.fy + k, less.fy + k),
                   rz = along(more.fz + k, less.fz + k);
        const auto cx = along(mid.fx + k + 1, mid.fx + k - 1), cy = along(mid.fy + k + 1, mid.fy + k - 1),
                   cz = along(mid.fz + k + 1, mid.fz + k - 1);
        auto x = hn::Sub(hn::Mul(ry, cz), hn::Mul(rz, cy));
        auto y = hn::Sub(hn::Mul(rz, cx), hn::Mul(rx, cz));
        auto z = hn::Sub(hn::Mul(rx, cy), hn::Mul(ry, cx));
        auto sum = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
        // Heights beyond any planet may fold a ring to nothing: its normal points outwards all the same.
        const auto flat = hn::Not(hn::Gt(sum, hn::Zero(f)));
        if (HWY_UNLIKELY(!hn::AllFalse(f, flat))) {
            const auto place = [&](const float* p, std::size_t axis) HWY_ATTR {
                return hn::Add(hn::LoadU(f, p), hn::Set(f, static_cast<float>(anchor_[axis])));
            };
            x = hn::IfThenElse(flat, place(mid.fx + k, 0), x);
            y = hn::IfThenElse(flat, place(mid.fy + k, 1), y);
            z = hn::IfThenElse(flat, place(mid.fz + k, 2), z);
            sum = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
        }
        const auto one = hn::Set(f, 1.0f), share = hn::Div(one, sum);
        auto u = hn::Mul(x, share), v = hn::Mul(y, share);
        const auto lower = hn::Lt(z, hn::Zero(f));
        const auto folded_u = hn::CopySign(hn::Sub(one, hn::Abs(v)), u);
        const auto folded_v = hn::CopySign(hn::Sub(one, hn::Abs(u)), v);
        // 1.5 * 2^23: the sum has the number, rounded to a whole one, in its lowest bits.
        const auto most = hn::Set(f, 32767.0f), whole = hn::Set(f, 12582912.0f);
        const auto iu = hn::BitCast(I32(), hn::Add(hn::Mul(hn::IfThenElse(lower, folded_u, u), most), whole));
        const auto iv = hn::BitCast(I32(), hn::Add(hn::Mul(hn::IfThenElse(lower, folded_v, v), most), whole));
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
    std::array<double, 3> anchor_{};
    std::array<std::int64_t, 3> anchor_bits_{};
    Scratch& scratch_;
};

template <class Height>
void Build(const PatchShape& shape, const Height* heights, std::size_t count, PatchVertex* out) {
    thread_local Scratch scratch;
    Builder(shape, out, scratch).run(heights, count);
}

void Build32(const PatchShape& shape, const std::int32_t* heights, std::size_t count, PatchVertex* out) {
    Build(shape, heights, count, out);
}
void Build64(const PatchShape& shape, const std::int64_t* heights, std::size_t count, PatchVertex* out) {
    Build(shape, heights, count, out);
}

}  // namespace carat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat {

HWY_EXPORT(Build32);
HWY_EXPORT(Build64);

void build_vertices(const PatchShape& shape, std::span<const std::int32_t> heights, PatchVertex* vertices) {
    HWY_DYNAMIC_DISPATCH(Build32)(shape, heights.data(), heights.size(), vertices);
}
void build_vertices(const PatchShape& shape, std::span<const std::int64_t> heights, PatchVertex* vertices) {
    HWY_DYNAMIC_DISPATCH(Build64)(shape, heights.data(), heights.size(), vertices);
}

}  // namespace carat
#endif
