#include "range_kernels.hpp"

#include <bit>
#include <cstring>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "range_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes-inl.hpp"

#if HWY_ARCH_X86
#include <immintrin.h>
#endif

#ifndef CARAT_RANGE_KERNEL_TABLES
#define CARAT_RANGE_KERNEL_TABLES
namespace carat::kernel {

// By mask of lanes: which word each lane takes if those of the mask take one each, in order.
inline constexpr auto kWordOfLane = [] {
    std::array<std::array<std::uint8_t, 8>, 256> t{};
    for (std::size_t mask = 0; mask < 256; ++mask)
        for (std::size_t lane = 0; lane < 8; ++lane)
            t[mask][lane] = static_cast<std::uint8_t>(std::popcount(mask & ((std::size_t{1} << lane) - 1)));
    return t;
}();

}  // namespace carat::kernel
#endif

HWY_BEFORE_NAMESPACE();
namespace carat::kernel::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::uint32_t kLeastState = 1u << 16;

// ---- passes ----

template <class T>
HWY_INLINE void deinterleave(const T* row, std::size_t count, T filling, T* even, T* odd) {
    std::size_t k = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::ScalableTag<T> d;
    const std::size_t lanes = hn::Lanes(d);
    for (; 2 * (k + lanes) <= count; k += lanes) {
        hn::Vec<decltype(d)> a, b;
        hn::LoadInterleaved2(d, row + 2 * k, a, b);
        hn::StoreU(a, d, even + k);
        hn::StoreU(b, d, odd + k);
    }
    const hn::CappedTag<T, 16> half;
    for (const std::size_t some = hn::Lanes(half); 2 * (k + some) <= count; k += some) {
        hn::Vec<decltype(half)> a, b;
        hn::LoadInterleaved2(half, row + 2 * k, a, b);
        hn::StoreU(a, half, even + k);
        hn::StoreU(b, half, odd + k);
    }
#endif
    for (; 2 * k + 1 < count; ++k) {
        even[k] = row[2 * k];
        odd[k] = row[2 * k + 1];
    }
    if (2 * k < count) {
        even[k] = row[2 * k];
        odd[k] = filling;
    }
}

template <class T>
HWY_INLINE void split(const T* cells, std::size_t stride, std::size_t rows, T filling, T* pass0, T* pass1) {
    const std::size_t pitch = (rows + 1) / 2;
    for (std::size_t i = 0; i < rows; ++i) {
        T *a = pass0 + i * pitch, *b = pass1 + i * pitch;
        deinterleave(cells + i * stride, rows, filling, i % 2 == 0 ? a : b, i % 2 == 0 ? b : a);
    }
}

void SplitWords(const std::uint32_t* cells, std::size_t stride, int rows, std::uint32_t filling,
                std::uint32_t* pass0, std::uint32_t* pass1) {
    split(cells, stride, static_cast<std::size_t>(rows), filling, pass0, pass1);
}
void SplitBytes(const std::uint8_t* cells, std::size_t stride, int rows, std::uint8_t* pass0,
                std::uint8_t* pass1) {
    split(cells, stride, static_cast<std::size_t>(rows), std::uint8_t{0}, pass0, pass1);
}

HWY_INLINE void interleave(const std::uint8_t* even, const std::uint8_t* odd, std::size_t count,
                           std::uint8_t* row) {
    std::size_t k = 0;
#if HWY_TARGET != HWY_SCALAR
    const hn::CappedTag<std::uint8_t, 32> d;
    for (const std::size_t lanes = hn::Lanes(d); 2 * (k + lanes) <= count; k += lanes)
        hn::StoreInterleaved2(hn::LoadU(d, even + k), hn::LoadU(d, odd + k), d, row + 2 * k);
#endif
    for (; 2 * k + 1 < count; ++k) {
        row[2 * k] = even[k];
        row[2 * k + 1] = odd[k];
    }
    if (2 * k < count) row[2 * k] = even[k];
}

void MergePasses(const std::uint8_t* pass0, const std::uint8_t* pass1, int size, std::uint8_t* cells) {
    const auto rows = static_cast<std::size_t>(size), pitch = (rows + 1) / 2;
    for (std::size_t i = 0; i < rows; ++i) {
        const std::uint8_t *a = pass0 + i * pitch, *b = pass1 + i * pitch;
        interleave(i % 2 == 0 ? a : b, i % 2 == 0 ? b : a, rows, cells + i * rows);
    }
}

// ---- neighbours ----

// f(d, k) for k = 0, Lanes(d), ... of bytes; smaller vectors at the end.
template <class F>
HWY_INLINE void for_bytes(std::size_t count, F f) {
    std::size_t k = 0;
    const hn::CappedTag<std::uint8_t, 32> d;
    for (; k + hn::Lanes(d) <= count; k += hn::Lanes(d)) f(d, k);
    const hn::CappedTag<std::uint8_t, 1> one;
    for (; k < count; ++k) f(one, k);
}

HWY_INLINE void seen_magnitudes(const std::uint8_t* token, std::size_t count, std::uint8_t* out) {
    // Tokens 16 to 23 stand for 16, 20, 24, 28, 32, 40, 48, 56 and more.
    static_assert(seen_magnitude(16) == 16 && seen_magnitude(19) == 28 && seen_magnitude(20) == 32 &&
                  seen_magnitude(23) == 56 && seen_magnitude(24) == kMostMagnitude);
    for_bytes(count, [&](auto d, std::size_t k) CARAT_INLINE_LAMBDA {
        const auto t = hn::LoadU(d, token + k);
        const auto fine = hn::Add(hn::Sub(t, hn::Set(d, 12)), hn::Sub(t, hn::Set(d, 12)));  // 2t - 24
        const auto once = hn::Add(fine, fine);   // 16: 16, 20, 24, 28 of 16 to 19
        const auto twice = hn::Add(once, once);  // 4 (2t - 24) of 20 to 23, less 32: 32 ...
        const auto low = hn::IfThenElse(hn::Lt(t, hn::Set(d, 20)), once, hn::Sub(twice, hn::Set(d, 32)));
        const auto high = hn::IfThenElse(hn::Lt(t, hn::Set(d, 24)), low, hn::Set(d, kMostMagnitude));
        hn::StoreU(hn::IfThenElse(hn::Lt(t, hn::Set(d, kDirectTokens)), t, high), d, out + k);
    });
}

void NeighbourMagnitudes(const std::uint8_t* token, int size, std::vector<std::uint8_t>& scratch,
                         std::uint8_t* near) {
    const auto rows = static_cast<std::size_t>(size), pitch = (rows + 1) / 2, stride = pitch + 2;
    if (scratch.size() != (rows + 2) * stride) scratch.assign((rows + 2) * stride, 0);  // the rim stays 0
    for (std::size_t i = 0; i < rows; ++i)
        seen_magnitudes(token + i * pitch, pitch, scratch.data() + (i + 1) * stride + 1);
    for (std::size_t i = 0; i < rows; ++i) {
        const std::uint8_t* at = scratch.data() + (i + 1) * stride + 1;
        const std::uint8_t* beside = i % 2 == 0 ? at + 1 : at - 1;
        for_bytes(pitch, [&](auto d, std::size_t k) CARAT_INLINE_LAMBDA {
            const auto across = hn::Add(hn::LoadU(d, at + k), hn::LoadU(d, beside + k));
            const auto along = hn::Add(hn::LoadU(d, at + k - stride), hn::LoadU(d, at + k + stride));
            hn::StoreU(hn::Add(across, along), d, near + i * pitch + k);
        });
    }
}

// ---- states ----

HWY_INLINE std::uint8_t step(const RangeTables::Model::Buckets& buckets, std::uint32_t& x,
                             std::size_t context) {
    const std::uint32_t slot = x & (kFrequencySum - 1), y = slot & (kBucketSize - 1),
                        bucket = slot >> kBucketBits;
    const std::size_t at = context * kTokens + bucket;
    const std::uint32_t split = buckets.split[at], alias = buckets.alias[at];
    const bool other = y >= split >> 24;
    const std::uint32_t f = (other ? split >> 12 : split) & (kFrequencySum - 1);
    const std::uint32_t first = other ? static_cast<std::uint32_t>(static_cast<std::int32_t>(alias) >> 6) : 0;
    x = f * (x >> kFrequencyBits) + y + first;
    return static_cast<std::uint8_t>(other ? alias & (kTokens - 1) : bucket);
}

// Whole rounds of kStates tokens; returns how many tokens. Words from after the end are found by the caller.
template <int kStates>
HWY_INLINE std::size_t plain_rounds(const RangeTables::Model::Buckets& buckets, StateRun& run,
                                    const std::uint8_t* context, std::size_t count, std::uint8_t* token) {
    std::array<std::uint32_t, kStates> x{};
    std::memcpy(x.data(), run.x.data(), sizeof x);
    const std::byte* next = run.next;
    std::size_t k = 0;
    for (; k + kStates <= count && next <= run.end; k += kStates)
        for (std::size_t lane = 0; lane < kStates; ++lane) {
            token[k + lane] = step(buckets, x[lane], context[k + lane]);
            std::uint16_t word = 0;
            std::memcpy(&word, next, 2);
            const bool low = x[lane] < kLeastState;
            x[lane] = low ? x[lane] << 16 | word : x[lane];
            next += low ? 2 : 0;
        }
    std::memcpy(run.x.data(), x.data(), sizeof x);
    run.next = next;
    return k;
}

#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
// A 16-bit word for each lane of the mask, in order; moves `next` behind them.
template <class D>
HWY_INLINE hn::Vec<D> next_words(D d, hn::Mask<D> need, const std::byte*& next) {
    const hn::Rebind<std::uint16_t, D> d16;
    const auto words = hn::PromoteTo(d, hn::LoadU(d16, reinterpret_cast<const std::uint16_t*>(next)));
    std::uint8_t mask = 0;
    hn::StoreMaskBits(d, need, &mask);
    next += 2 * std::popcount(mask);
#if HWY_TARGET <= HWY_AVX3
    return hn::Vec<D>{_mm256_maskz_expand_epi32(need.raw, words.raw)};
#else
    const hn::Rebind<std::uint8_t, D> d8;
    const auto place = hn::PromoteTo(d, hn::LoadU(d8, kWordOfLane[mask].data()));
    return hn::TableLookupLanes(words, hn::IndicesFromVec(d, place));
#endif
}

// Eight states a vector.
template <int kStates>
HWY_INLINE std::size_t rounds(const RangeTables::Model::Buckets& buckets, StateRun& run,
                              const std::uint8_t* context, std::size_t count, std::uint8_t* token) {
    if constexpr (kStates < 8) {
        return plain_rounds<kStates>(buckets, run, context, count, token);
    } else {
        constexpr std::size_t kVectors = kStates / 8;
        const hn::FixedTag<std::uint32_t, 8> d;
        const hn::FixedTag<std::int32_t, 8> di;
        const hn::Rebind<std::uint8_t, decltype(d)> d8;
        const auto low_bits = hn::Set(d, kFrequencySum - 1), bucket_bits = hn::Set(d, kBucketSize - 1);
        const auto* split = buckets.split.data();
        const auto* alias = buckets.alias.data();
        hn::Vec<decltype(d)> x[kVectors];
        for (std::size_t v = 0; v < kVectors; ++v) x[v] = hn::LoadU(d, run.x.data() + 8 * v);
        const std::byte* next = run.next;
        std::size_t k = 0;
        for (; k + kStates <= count && next <= run.end; k += kStates)
            for (std::size_t v = 0; v < kVectors; ++v) {
                const auto slot = hn::And(x[v], low_bits), y = hn::And(slot, bucket_bits),
                           bucket = hn::ShiftRight<kBucketBits>(slot);
                const auto in = hn::PromoteTo(d, hn::LoadU(d8, context + k + 8 * v));
                const auto at = hn::BitCast(di, hn::Add(hn::ShiftLeft<6>(in), bucket));
                const auto s = hn::GatherIndex(d, split, at), a = hn::GatherIndex(d, alias, at);
                // Both products while it is found out which one counts.
                const auto own =
                    hn::RebindMask(d, hn::Lt(hn::BitCast(di, y), hn::BitCast(di, hn::ShiftRight<24>(s))));
                const auto high = hn::ShiftRight<kFrequencyBits>(x[v]);
                const auto if_own = hn::Mul(hn::And(s, low_bits), high),
                           if_other = hn::Mul(hn::And(hn::ShiftRight<12>(s), low_bits), high);
                const auto first = hn::BitCast(d, hn::ShiftRight<6>(hn::BitCast(di, a)));
                const auto t = hn::IfThenElse(own, bucket, hn::And(a, hn::Set(d, kTokens - 1)));
                const auto number = hn::Add(y, hn::IfThenZeroElse(own, first));
                const auto moved = hn::Add(hn::IfThenElse(own, if_own, if_other), number);
                const auto need = hn::Eq(hn::ShiftRight<16>(moved), hn::Zero(d));
                const auto refilled = hn::Or(hn::ShiftLeft<16>(moved), next_words(d, need, next));
                x[v] = hn::IfThenElse(need, refilled, moved);
                hn::StoreU(hn::DemoteTo(d8, hn::BitCast(di, t)), d8, token + k + 8 * v);
            }
        for (std::size_t v = 0; v < kVectors; ++v) hn::StoreU(x[v], d, run.x.data() + 8 * v);
        run.next = next;
        return k;
    }
}
#else
template <int kStates>
HWY_INLINE std::size_t rounds(const RangeTables::Model::Buckets& buckets, StateRun& run,
                              const std::uint8_t* context, std::size_t count, std::uint8_t* token) {
    return plain_rounds<kStates>(buckets, run, context, count, token);
}
#endif

template <int kStates>
HWY_INLINE bool decode(const RangeTables::Model::Buckets& buckets, StateRun& run, const std::uint8_t* context,
                       std::size_t count, std::uint8_t* token) {
    std::size_t k = rounds<kStates>(buckets, run, context, count, token);
    for (; k < count; ++k) {
        std::uint32_t& x = run.x[k % kStates];
        token[k] = step(buckets, x, context[k]);
        if (x >= kLeastState) continue;
        if (run.next > run.end) return false;
        std::uint16_t word = 0;
        std::memcpy(&word, run.next, 2);
        x = x << 16 | word;
        run.next += 2;
    }
    return run.next <= run.end;
}

bool DecodeTokens(const RangeTables::Model::Buckets& buckets, int states, StateRun& run,
                  const std::uint8_t* context, std::size_t count, std::uint8_t* token) {
    switch (states) {
        case 1:
            return decode<1>(buckets, run, context, count, token);
        case 2:
            return decode<2>(buckets, run, context, count, token);
        case 4:
            return decode<4>(buckets, run, context, count, token);
        case 8:
            return decode<8>(buckets, run, context, count, token);
        case 16:
            return decode<16>(buckets, run, context, count, token);
        default:
            return decode<32>(buckets, run, context, count, token);
    }
}

// ---- indices ----

TokenCensus TakeCensus(const std::uint8_t* token, std::size_t count, std::uint16_t* big) {
    TokenCensus sum{0, 0};
    for_bytes(count, [&](auto d, std::size_t k) CARAT_INLINE_LAMBDA {
        const auto t = hn::LoadU(d, token + k);
        sum.nonzero += static_cast<std::size_t>(std::popcount(mask_bits(d, hn::Ne(t, hn::Zero(d)))));
        std::uint64_t bits = mask_bits(d, hn::Gt(t, hn::Set(d, kDirectTokens - 1)));
        for (; bits != 0; bits &= bits - 1)
            big[sum.big++] = static_cast<std::uint16_t>(k + static_cast<std::size_t>(std::countr_zero(bits)));
    });
    return sum;
}

HWY_INLINE void plain_signs(const std::uint8_t* token, std::size_t count, const std::uint8_t* raw,
                            std::size_t at, std::int32_t* index) {
    for (std::size_t k = 0; k < count; ++k) {
        const unsigned negative = token[k] != 0 ? raw[at / 8] >> (at % 8) & 1u : 0u;
        index[k] = with_sign(token[k], negative);
        at += token[k] != 0 ? 1 : 0;
    }
}

#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
void ApplySigns(const std::uint8_t* token, std::size_t count, const std::uint8_t* raw, std::int32_t* index) {
    const hn::FixedTag<std::uint8_t, 32> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::ScalableTag<std::int32_t> d32;
    const hn::Rebind<std::int8_t, decltype(d32)> part;
    std::size_t at = 0, k = 0;
    for (; k + 32 <= count; k += 32) {
        const auto t = hn::LoadU(d, token + k);
        const std::uint64_t nonzero = mask_bits(d, hn::Ne(t, hn::Zero(d)));
        std::uint64_t word = 0;
        std::memcpy(&word, raw + at / 8, 8);
        const std::uint64_t negative = _pdep_u64(word >> (at % 8), nonzero);
        at += static_cast<std::size_t>(std::popcount(nonzero));
        const auto minus = hn::LoadMaskBits(di, reinterpret_cast<const std::uint8_t*>(&negative));
        const auto plus = hn::BitCast(di, t);
        alignas(32) std::int8_t both[32];
        hn::Store(hn::IfThenElse(minus, hn::Neg(plus), plus), di, both);
        for (std::size_t lane = 0; lane < 32; lane += hn::Lanes(d32))
            hn::StoreU(hn::PromoteTo(d32, hn::LoadU(part, both + lane)), d32, index + k + lane);
    }
    plain_signs(token + k, count - k, raw, at, index + k);
}
#else
void ApplySigns(const std::uint8_t* token, std::size_t count, const std::uint8_t* raw, std::int32_t* index) {
    plain_signs(token, count, raw, 0, index);
}
#endif

void MakeTokens(const std::int32_t* index, std::size_t count, std::uint8_t* token) {
    std::uint32_t most = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const auto sign = static_cast<std::uint32_t>(index[k] >> 31);
        const std::uint32_t m = (static_cast<std::uint32_t>(index[k]) ^ sign) - sign;
        most |= m;
        token[k] = static_cast<std::uint8_t>(m);
    }
    if (most < kDirectTokens) return;
    for (std::size_t k = 0; k < count; ++k)
        token[k] = static_cast<std::uint8_t>(token_of(magnitude_of(index[k])));
}

}  // namespace carat::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat::kernel {

HWY_EXPORT(SplitWords);
HWY_EXPORT(SplitBytes);
HWY_EXPORT(MergePasses);
HWY_EXPORT(NeighbourMagnitudes);
HWY_EXPORT(DecodeTokens);
HWY_EXPORT(TakeCensus);
HWY_EXPORT(ApplySigns);
HWY_EXPORT(MakeTokens);

void split_passes(const std::uint32_t* cells, std::size_t stride, int rows, std::uint32_t filling,
                  std::uint32_t* pass0, std::uint32_t* pass1) {
    HWY_DYNAMIC_DISPATCH(SplitWords)(cells, stride, rows, filling, pass0, pass1);
}
void split_passes(const std::uint8_t* cells, std::size_t stride, int rows, std::uint8_t* pass0,
                  std::uint8_t* pass1) {
    HWY_DYNAMIC_DISPATCH(SplitBytes)(cells, stride, rows, pass0, pass1);
}
void merge_passes(const std::uint8_t* pass0, const std::uint8_t* pass1, int rows, std::uint8_t* cells) {
    HWY_DYNAMIC_DISPATCH(MergePasses)(pass0, pass1, rows, cells);
}
void neighbour_magnitudes(const std::uint8_t* token, int rows, std::vector<std::uint8_t>& scratch,
                          std::uint8_t* near) {
    HWY_DYNAMIC_DISPATCH(NeighbourMagnitudes)(token, rows, scratch, near);
}
bool decode_tokens(const RangeTables::Model::Buckets& buckets, int states, StateRun& run,
                   const std::uint8_t* context, std::size_t count, std::uint8_t* token) {
    return HWY_DYNAMIC_DISPATCH(DecodeTokens)(buckets, states, run, context, count, token);
}
TokenCensus take_census(const std::uint8_t* token, std::size_t count, std::uint16_t* big) {
    return HWY_DYNAMIC_DISPATCH(TakeCensus)(token, count, big);
}
void apply_signs(const std::uint8_t* token, std::size_t count, const std::uint8_t* raw, std::int32_t* index) {
    HWY_DYNAMIC_DISPATCH(ApplySigns)(token, count, raw, index);
}
void make_tokens(const std::int32_t* index, std::size_t count, std::uint8_t* token) {
    HWY_DYNAMIC_DISPATCH(MakeTokens)(index, count, token);
}

}  // namespace carat::kernel
#endif  // HWY_ONCE
