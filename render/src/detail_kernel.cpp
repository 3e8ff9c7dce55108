#include "detail_kernel.hpp"

#include <cstddef>

#include "detail_code.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detail_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using I64 = hn::ScalableTag<std::int64_t>;
using I32 = hn::Rebind<std::int32_t, I64>;
using U32 = hn::Rebind<std::uint32_t, I64>;
using V64 = hn::Vec<I64>;
using V32 = hn::Vec<I32>;
using W32 = hn::Vec<U32>;

// Three coordinates, each followed by a step that brings high bits down; the last ones are Murmur's.
HWY_INLINE W32 hash(V32 x, V32 y, V32 z, std::uint32_t salt) {
    const U32 u;
    const auto k = [u](std::uint32_t value) HWY_ATTR { return hn::Set(u, value); };
    W32 h = hn::Add(hn::Mul(hn::BitCast(u, x), k(0x9E3779B1u)), k(salt));
    h = hn::Xor(h, hn::ShiftRight<15>(h));
    h = hn::Mul(hn::Add(h, hn::BitCast(u, y)), k(0x85EBCA77u));
    h = hn::Xor(h, hn::ShiftRight<13>(h));
    h = hn::Mul(hn::Add(h, hn::BitCast(u, z)), k(0xC2B2AE3Du));
    h = hn::Xor(h, hn::ShiftRight<16>(h));
    h = hn::Mul(h, k(0x27D4EB2Fu));
    return hn::Xor(h, hn::ShiftRight<15>(h));
}

HWY_INLINE V32 decayed(V32 amplitude, V32 decay) {
    const I32 d;
    const auto next = hn::Max(hn::Sub(amplitude, decay), hn::Set(d, kNoAmplitude));
    return hn::Or(hn::ShiftLeft<16>(next), decay);
}

class Synthesis {
  public:
    Synthesis(const SynthesisJob& job, const std::int64_t* v, const std::int32_t* rough, std::int64_t* c,
              std::int32_t* rough_c)
        : job_(job), v_(v), rough_(rough), c_(c), rough_c_(rough_c) {}

    // Vectors that reach beyond a row's end, or beyond side 0, are overwritten by what comes next.
    void run() const {
        for (int i = 0; i < job_.cells; ++i) {
            row(i, 0, i + 1, job_.sides[0]);
            row(i, i + 1, job_.cells, job_.sides[1]);
        }
    }

  private:
    void row(int i, int from, int to, const CellGrid& grid) const {
        const I32 d;
        const int lanes = static_cast<int>(hn::Lanes(d)), n = job_.cells + 1;
        const V32 steps = hn::Iota(d, 0);
        const auto coordinate = [&](std::size_t axis) HWY_ATTR {
            const std::int32_t first = grid.origin[axis] + i * grid.u[axis] + from * grid.v[axis];
            return hn::Add(hn::Set(d, first), hn::Mul(steps, hn::Set(d, grid.v[axis])));
        };
        V32 x = coordinate(0), y = coordinate(1), z = coordinate(2);
        const V32 dx = hn::Set(d, lanes * grid.v[0]), dy = hn::Set(d, lanes * grid.v[1]),
                  dz = hn::Set(d, lanes * grid.v[2]);
        for (int j = from; j < to; j += lanes) {
            const std::ptrdiff_t at = std::ptrdiff_t{i} * n + j;
            cells(at, n, ((i ^ j) & 1) == 0, hash(x, y, z, job_.salt), std::ptrdiff_t{i} * job_.cells + j);
            x = hn::Add(x, dx);
            y = hn::Add(y, dy);
            z = hn::Add(z, dz);
        }
    }

    // main: of the first cell's diagonal; it alternates.
    HWY_INLINE void cells(std::ptrdiff_t at, int n, bool main, W32 hashed, std::ptrdiff_t out) const {
        const I64 w;
        const I32 d;
        const auto odd64 = hn::Ne(hn::And(hn::Iota(w, 0), hn::Set(w, 1)), hn::Zero(w));
        const auto odd32 = hn::Ne(hn::And(hn::Iota(d, 0), hn::Set(d, 1)), hn::Zero(d));
        const auto anti64 = main ? odd64 : hn::Not(odd64);
        const auto anti32 = main ? odd32 : hn::Not(odd32);

        const V32 r00 = hn::LoadU(d, rough_ + at), r01 = hn::LoadU(d, rough_ + at + 1);
        const V32 r10 = hn::LoadU(d, rough_ + at + n), r11 = hn::LoadU(d, rough_ + at + n + 1);
        const V32 ra = hn::IfThenElse(anti32, r01, r00), rb = hn::IfThenElse(anti32, r10, r11);
        const V32 low = hn::Set(d, 0xFFFF);
        const V32 log = hn::Min(hn::ShiftRight<1>(hn::Add(hn::ShiftRight<16>(ra), hn::ShiftRight<16>(rb))),
                                hn::Set(d, job_.cap));
        const V32 decay = hn::ShiftRight<1>(hn::Add(hn::And(ra, low), hn::And(rb, low)));
        hn::StoreU(decayed(log, decay), d, rough_c_ + out);

        // 2^e (1 + f/256) quanta; noise is 0.7 u of it, u 16 bits.
        const auto some = hn::Gt(log, hn::Set(d, kLeastAmplitude - 1));
        const V32 mantissa =
            hn::IfThenElseZero(some, hn::Add(hn::And(log, hn::Set(d, 255)), hn::Set(d, kOctave)));
        const V32 shift =
            hn::Add(hn::ShiftRight<8>(hn::Max(log, hn::Set(d, kLeastAmplitude))), hn::Set(d, 14));
        const V32 u = hn::ShiftRight<8>(hn::Mul(hn::ShiftRight<16>(hn::BitCast(d, hashed)), hn::Set(d, 179)));
        const V64 by = hn::PromoteTo(w, shift);
        const auto scaled = [&](V32 value) HWY_ATTR {  // value 2^(e + 2), in 2^-25 quanta
            return hn::ShiftRight<12>(hn::Shl(hn::PromoteTo(w, value), by));
        };
        const V64 noise = scaled(hn::Mul(mantissa, u));
        const V64 most = scaled(hn::ShiftLeft<15>(mantissa));

        const V64 v00 = hn::LoadU(w, v_ + at), v01 = hn::LoadU(w, v_ + at + 1);
        const V64 v10 = hn::LoadU(w, v_ + at + n), v11 = hn::LoadU(w, v_ + at + n + 1);
        const V64 main_sum = hn::Add(v00, v11), anti_sum = hn::Add(v01, v10);
        const V64 ends = hn::IfThenElse(anti64, anti_sum, main_sum);
        const V64 others = hn::IfThenElse(anti64, main_sum, anti_sum);
        const V64 bend = hn::ShiftRight<2>(hn::Sub(others, ends));
        const V64 residual = hn::Max(hn::Neg(most), hn::Min(hn::Add(bend, noise), most));
        hn::StoreU(hn::Add(hn::ShiftRight<1>(ends), residual), w, c_ + out);
    }

    const SynthesisJob& job_;
    const std::int64_t* v_;
    const std::int32_t* rough_;
    std::int64_t* c_;
    std::int32_t* rough_c_;
};

void Synthesise(const SynthesisJob& job, const std::int64_t* v, const std::int32_t* rough, std::int64_t* c,
                std::int32_t* rough_c) {
    Synthesis(job, v, rough, c, rough_c).run();
}

void Decay(std::int32_t cap, std::int32_t* rough, std::size_t count) {
    const I32 d;
    for (std::size_t k = 0; k < count; k += hn::Lanes(d)) {
        const V32 r = hn::LoadU(d, rough + k);
        const V32 log = hn::Min(hn::ShiftRight<16>(r), hn::Set(d, cap));
        hn::StoreU(decayed(log, hn::And(r, hn::Set(d, 0xFFFF))), d, rough + k);
    }
}

std::uint32_t Hash(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t salt) {
    const I32 d;
    return hn::GetLane(hash(hn::Set(d, x), hn::Set(d, y), hn::Set(d, z), salt));
}

}  // namespace carat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat {

HWY_EXPORT(Synthesise);
HWY_EXPORT(Decay);
HWY_EXPORT(Hash);

void synthesise_centres(const SynthesisJob& job, const std::int64_t* v, const std::int32_t* rough,
                        std::int64_t* c, std::int32_t* rough_c) {
    HWY_DYNAMIC_DISPATCH(Synthesise)(job, v, rough, c, rough_c);
}
void decay_roughness(std::int32_t cap, std::int32_t* rough, std::size_t count) {
    HWY_DYNAMIC_DISPATCH(Decay)(cap, rough, count);
}
std::uint32_t detail_hash(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t salt) {
    return HWY_DYNAMIC_DISPATCH(Hash)(x, y, z, salt);
}

}  // namespace carat
#endif
