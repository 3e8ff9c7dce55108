// Loops shared by the kernels' files, once a Highway target. Include within a file that hwy/foreach_target.h
// compiles anew for each target, after it.
#if defined(CARAT_CODEC_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef CARAT_CODEC_LANES_INL_HPP
#undef CARAT_CODEC_LANES_INL_HPP
#else
#define CARAT_CODEC_LANES_INL_HPP
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

// Bodies of vector loops must not become calls.
#undef CARAT_INLINE_LAMBDA
#define CARAT_INLINE_LAMBDA __attribute__((always_inline))

HWY_BEFORE_NAMESPACE();
namespace carat::kernel::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// f(d, k) for k = begin, begin + Lanes(d), ...; the last vector may overlap the one before (f must give the
// same again); below one vector, lane by lane.
template <class F>
HWY_INLINE void for_lanes(std::ptrdiff_t begin, std::ptrdiff_t end, F f) {
    const hn::ScalableTag<std::int32_t> d;
    const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));
    std::ptrdiff_t k = begin;
    for (; k + lanes <= end; k += lanes) f(d, k);
    if (k == end) return;
    if (end - begin >= lanes) {
        f(d, end - lanes);
        return;
    }
    const hn::CappedTag<std::int32_t, 1> one;
    for (; k < end; ++k) f(one, k);
}

// One bit a lane, the first one lowest. g++ 12.2 may widen a mask of 32 bits while it is in a mask register,
// spill four bytes of it and read eight back: seen under ThreadSanitizer, whose calls leave no register. What
// is in a general register is widened there.
template <class D>
HWY_INLINE std::uint64_t mask_bits(D d, hn::Mask<D> mask) {
    static_assert(hn::MaxLanes(D()) <= 32);
    std::uint32_t bits = 0;
    hn::StoreMaskBits(d, mask, reinterpret_cast<std::uint8_t*>(&bits));
#if HWY_COMPILER_GCC_ACTUAL
    __asm__("" : "+r"(bits));
#endif
    return bits;
}

template <class DU>
HWY_INLINE hn::Vec<DU> load_unsigned(DU du, const std::int32_t* p) {
    return hn::BitCast(du, hn::LoadU(hn::RebindToSigned<DU>(), p));
}

// carat::quantize of a residual modulo 2^32, for the compiler to vectorise: an estimate by a double
// reciprocal is at most one off; the remainder mends it.
struct Quantizer {
    explicit Quantizer(std::int32_t r)
        : radius(r), step(2 * std::int64_t{r} + 1), inverse(1.0 / static_cast<double>(step)) {}

    HWY_INLINE std::int32_t index(std::uint32_t residual) const {
        const auto r = static_cast<std::int32_t>(residual);
        const auto guess = static_cast<std::int32_t>(static_cast<double>(r) * inverse);
        const std::int64_t rest = r - guess * step;
        return guess + (rest > radius ? 1 : 0) - (rest < -std::int64_t{radius} ? 1 : 0);
    }

    std::int32_t radius;
    std::int64_t step;
    double inverse;
};

}  // namespace carat::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // CARAT_CODEC_LANES_INL_HPP
