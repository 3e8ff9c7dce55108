#include "gamma_kernels.hpp"

#include <bit>
#include <cstring>

#include "gamma_code.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gamma_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes-inl.hpp"

#if HWY_ARCH_X86
#include <immintrin.h>
#endif

HWY_BEFORE_NAMESPACE();
namespace carat::kernel::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE std::uint64_t load_word(const std::byte* p) {
    std::uint64_t word = 0;
    std::memcpy(&word, p, 8);
    return word;
}

// Places of the ones of a word, in eights: more than there are may be written.
HWY_INLINE std::size_t ones_of(std::uint64_t word, std::uint8_t base, std::uint8_t* out) {
    const int count = std::popcount(word);
    for (int done = 0; done < count; done += 8)
        for (int k = 0; k < 8; ++k) {
            out[done + k] = static_cast<std::uint8_t>(base + std::countr_zero(word));
            word &= word - 1;
        }
    return static_cast<std::size_t>(count);
}

RunEnd Ones(BitRun& run, std::size_t count, std::uint8_t* ends) {
    if (count == 0) return RunEnd::good;
    std::size_t word_at = run.at / 64, found = 0;
    std::uint64_t word = load_word(run.bytes + 8 * word_at) & (~std::uint64_t{0} << (run.at % 64));
    for (;;) {
        const std::size_t before = found;
        found += ones_of(word, static_cast<std::uint8_t>(64 * word_at), ends + found);
        if (found >= count) {
            for (std::size_t k = before; k + 1 < count; ++k) word &= word - 1;
            run.at = 64 * word_at + static_cast<std::size_t>(std::countr_zero(word)) + 1;
            return run.at <= run.end ? RunEnd::good : RunEnd::truncated;
        }
        ++word_at;
        if (64 * word_at >= run.end) return RunEnd::truncated;
        word = load_word(run.bytes + 8 * word_at);
        if (word == 0) return RunEnd::corrupt;
    }
}

// Codes one by one.
HWY_INLINE RunEnd plain_suffixes(const std::byte* bytes, std::size_t& at, std::size_t count,
                                 const std::uint8_t* ends, std::int32_t* values) {
    for (std::size_t k = 0; k < count; ++k) {
        const int n = static_cast<std::uint8_t>(ends[k] - ends[static_cast<std::ptrdiff_t>(k) - 1] - 1);
        if (n > 32) return RunEnd::corrupt;
        const std::uint64_t bits = load_word(bytes + at / 8) >> (at % 8);
        const std::uint64_t code = (std::uint64_t{1} << n) | (bits & ((std::uint64_t{1} << n) - 1));
        if (code > std::uint64_t{1} << 32) return RunEnd::corrupt;
        values[k] = value_of_gamma(code);
        at += static_cast<std::size_t>(n);
    }
    return RunEnd::good;
}

#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
// Eight codes of at most 7 suffix bits each at a time: pdep lays a suffix into each byte.
RunEnd Suffixes(BitRun& run, std::size_t count, const std::uint8_t* ends, std::int32_t* values) {
    const hn::Full64<std::uint8_t> d8;
    const hn::FixedTag<std::int32_t, 8> d32;
    alignas(16) static constexpr std::uint8_t kPower[16] = {1, 2, 4, 8, 16, 32, 64, 128};
    const auto power = hn::LoadDup128(d8, kPower);
    std::size_t at = run.at;
    for (std::size_t k = 0; k < count; k += 8) {
        if (at > run.end) return RunEnd::truncated;
        const std::size_t some = count - k < 8 ? count - k : 8;
        const auto n = hn::Sub(hn::Sub(hn::LoadU(d8, ends + k), hn::LoadU(d8, ends + k - 1)), hn::Set(d8, 1));
        if (some < 8 || !hn::AllTrue(d8, hn::Lt(n, hn::Set(d8, 8)))) {
            if (const RunEnd e = plain_suffixes(run.bytes, at, some, ends + k, values + k); e != RunEnd::good)
                return e;
            continue;
        }
        const auto one = hn::TableLookupBytes(power, n);  // 2^n
        const hn::Repartition<std::uint64_t, decltype(d8)> d64;
        const std::uint64_t mask = hn::GetLane(hn::BitCast(d64, hn::Sub(one, hn::Set(d8, 1))));
        const std::uint64_t bits = load_word(run.bytes + at / 8) >> (at % 8);
        const auto low = hn::BitCast(d8, hn::Set(d64, _pdep_u64(bits, mask)));
        at += static_cast<std::size_t>(std::popcount(mask));
        const auto z = hn::Sub(hn::Or(one, low), hn::Set(d8, 1));  // at most 254
        const hn::RebindToSigned<decltype(d8)> di8;
        const auto sign = hn::Neg(hn::BitCast(di8, hn::And(z, hn::Set(d8, 1))));
        const auto half =
            hn::BitCast(di8, hn::And(hn::BitCast(d8, hn::ShiftRight<1>(hn::BitCast(
                                                         hn::Repartition<std::uint16_t, decltype(d8)>(), z))),
                                     hn::Set(d8, 127)));
        hn::StoreU(hn::PromoteTo(d32, hn::Xor(half, sign)), d32, values + k);
    }
    run.at = at;
    return at <= run.end ? RunEnd::good : RunEnd::truncated;
}
#else
RunEnd Suffixes(BitRun& run, std::size_t count, const std::uint8_t* ends, std::int32_t* values) {
    constexpr std::size_t kSome = 8;  // 8 x 32 bits lie within the padding
    for (std::size_t k = 0; k < count; k += kSome) {
        if (run.at > run.end) return RunEnd::truncated;
        const RunEnd e =
            plain_suffixes(run.bytes, run.at, count - k < kSome ? count - k : kSome, ends + k, values + k);
        if (e != RunEnd::good) return e;
    }
    return run.at <= run.end ? RunEnd::good : RunEnd::truncated;
}
#endif

HWY_INLINE std::uint64_t plain_code_bits(const std::int32_t* values, std::size_t count) {
    std::uint64_t sum = 0;
    for (std::size_t k = 0; k < count; ++k)
        sum += 2 * static_cast<std::uint64_t>(std::bit_width(gamma_of(values[k]))) - 1;
    return sum;
}

std::uint64_t CodeBits(const std::int32_t* values, std::size_t count) {
    std::size_t k = 0;
    std::uint64_t sum = 0;
#if HWY_TARGET != HWY_SCALAR
    std::uint32_t most = 0;
    for (std::size_t j = 0; j < count; ++j)
        most |= static_cast<std::uint32_t>(values[j]) ^ static_cast<std::uint32_t>(values[j] >> 31);
    if (most >= 1u << 29 || count > 1u << 20) return plain_code_bits(values, count);  // no sum overflows
    const hn::ScalableTag<std::int32_t> d;
    const hn::RebindToFloat<decltype(d)> df;
    auto exponents = hn::Zero(d);
    for (; k + hn::Lanes(d) <= count; k += hn::Lanes(d)) {
        const auto v = hn::LoadU(d, values + k);
        const auto x = hn::Add(hn::Xor(hn::ShiftLeft<1>(v), hn::ShiftRight<31>(v)), hn::Set(d, 1));
        // Without the second highest bit no rounding reaches the next power of two.
        const auto rounded = hn::ConvertTo(df, hn::AndNot(hn::ShiftRight<1>(x), x));
        exponents = hn::Add(exponents, hn::Sub(hn::ShiftRight<23>(hn::BitCast(d, rounded)), hn::Set(d, 127)));
    }
    sum = 2 * static_cast<std::uint64_t>(hn::GetLane(hn::SumOfLanes(d, exponents))) + k;
#endif
    return sum + plain_code_bits(values + k, count - k);
}

void NonzeroBits(const std::int32_t* values, std::size_t count, std::uint64_t* words) {
    for (std::size_t begin = 0; begin < count; begin += 64) {
        const std::size_t some = count - begin < 64 ? count - begin : 64;
        std::uint64_t word = 0;
        std::size_t k = 0;
#if HWY_TARGET != HWY_SCALAR
        const hn::ScalableTag<std::int32_t> d;
        for (; k + hn::Lanes(d) <= some && hn::Lanes(d) % 8 == 0; k += hn::Lanes(d)) {
            word |= mask_bits(d, hn::Ne(hn::LoadU(d, values + begin + k), hn::Zero(d))) << k;
        }
#endif
        for (; k < some; ++k) word |= std::uint64_t{values[begin + k] != 0 ? 1u : 0u} << k;
        words[begin / 64] = word;
    }
}

}  // namespace carat::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat::kernel {

HWY_EXPORT(Ones);
HWY_EXPORT(Suffixes);
HWY_EXPORT(CodeBits);
HWY_EXPORT(NonzeroBits);

RunEnd ones(BitRun& run, std::size_t count, std::uint8_t* ends) {
    return HWY_DYNAMIC_DISPATCH(Ones)(run, count, ends);
}
RunEnd suffixes(BitRun& run, std::size_t count, const std::uint8_t* ends, std::int32_t* values) {
    return HWY_DYNAMIC_DISPATCH(Suffixes)(run, count, ends, values);
}
std::uint64_t code_bits(const std::int32_t* values, std::size_t count) {
    return HWY_DYNAMIC_DISPATCH(CodeBits)(values, count);
}
void nonzero_bits(const std::int32_t* values, std::size_t count, std::uint64_t* words) {
    HWY_DYNAMIC_DISPATCH(NonzeroBits)(values, count, words);
}

}  // namespace carat::kernel
#endif  // HWY_ONCE
