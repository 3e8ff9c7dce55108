#include "update_kernels.hpp"

#include <cstddef>

#include "carat/codec/heights.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "update_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace carat::kernel::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// f(first inner vertex of a row in n x n, the same in (n-2) x (n-2)).
template <class F>
HWY_INLINE void for_inner_rows(std::ptrdiff_t n, F f) {
    for (std::ptrdiff_t i = 1; i < n - 1; ++i) f(i * n + 1, (i - 1) * (n - 2));
}

template <bool kPredicted>
HWY_INLINE void quantize_inside(const std::int32_t* v, const VertexBase& base, std::ptrdiff_t n,
                                const Quantizer& quantizer, std::int32_t* index) {
    for_inner_rows(n, [&](std::ptrdiff_t vertex, std::ptrdiff_t inner) CARAT_INLINE_LAMBDA {
        const std::int32_t *from = v + vertex, *p = base.p + vertex;
        const std::int32_t* predicted = kPredicted ? base.predicted + inner : nullptr;
        std::int32_t* to = index + inner;
        for (std::ptrdiff_t j = 0; j < n - 2; ++j) {
            auto b = static_cast<std::uint32_t>(p[j]);
            if constexpr (kPredicted) b = 2 * b - static_cast<std::uint32_t>(predicted[j]);
            to[j] = quantizer.index(static_cast<std::uint32_t>(from[j]) - b);
        }
    });
}

void QuantizeVertices(const std::int32_t* v, const VertexBase& base, int n, std::int32_t radius,
                      std::int32_t* index) {
    if (base.predicted == nullptr)
        quantize_inside<false>(v, base, n, Quantizer(radius), index);
    else
        quantize_inside<true>(v, base, n, Quantizer(radius), index);
}

template <bool kPredicted>
HWY_INLINE void update_inside(const VertexBase& base, const std::int32_t* index, std::ptrdiff_t n,
                              std::int32_t step, std::int32_t* v) {
    for_inner_rows(n, [&](std::ptrdiff_t vertex, std::ptrdiff_t inner) CARAT_INLINE_LAMBDA {
        for_lanes(0, n - 2, [&](auto d, std::ptrdiff_t j) CARAT_INLINE_LAMBDA {
            const hn::RebindToUnsigned<decltype(d)> du;
            auto b = load_unsigned(du, base.p + vertex + j);
            if constexpr (kPredicted)
                b = hn::Sub(hn::Add(b, b), load_unsigned(du, base.predicted + inner + j));
            const auto residual =
                hn::Mul(load_unsigned(du, index + inner + j), hn::Set(du, static_cast<std::uint32_t>(step)));
            hn::StoreU(hn::BitCast(d, hn::Add(b, residual)), d, v + vertex + j);
        });
    });
}

void UpdateVertices(const VertexBase& base, const std::int32_t* index, int n, std::int32_t step,
                    std::int32_t* v) {
    if (base.predicted == nullptr)
        update_inside<false>(base, index, n, step, v);
    else
        update_inside<true>(base, index, n, step, v);
}

void FilterVertices(const std::int32_t* v, const std::int32_t* predicted, int n, std::int32_t* p) {
    // From the last row on: what is written lies behind all that is still to be read.
    const std::ptrdiff_t inside = n - 2;
    for (std::ptrdiff_t i = inside; i > 0; --i) {
        const std::ptrdiff_t vertex = i * n + 1, inner = (i - 1) * inside;
        for_lanes(0, inside, [&](auto d, std::ptrdiff_t j) CARAT_INLINE_LAMBDA {
            const auto a = hn::LoadU(d, v + vertex + j), b = hn::LoadU(d, predicted + inner + j);
            // floor((a + b + 1) / 2) without a carry: a + b = 2 (a | b) - (a ^ b).
            const auto mean = hn::Sub(hn::Or(a, b), hn::ShiftRight<1>(hn::Xor(a, b)));
            const auto held =
                hn::Min(hn::Max(mean, hn::Set(d, -kGreatestHeight)), hn::Set(d, kGreatestHeight));
            hn::StoreU(held, d, p + vertex + j);
        });
    }
}

}  // namespace carat::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat::kernel {

HWY_EXPORT(QuantizeVertices);
HWY_EXPORT(UpdateVertices);
HWY_EXPORT(FilterVertices);

void quantize_vertices(const std::int32_t* v, const VertexBase& base, int n, std::int32_t radius,
                       std::int32_t* index) {
    HWY_DYNAMIC_DISPATCH(QuantizeVertices)(v, base, n, radius, index);
}
void update_vertices(const VertexBase& base, const std::int32_t* index, int n, std::int32_t step,
                     std::int32_t* v) {
    HWY_DYNAMIC_DISPATCH(UpdateVertices)(base, index, n, step, v);
}
void filter_vertices(const std::int32_t* v, const std::int32_t* predicted, int n, std::int32_t* p) {
    HWY_DYNAMIC_DISPATCH(FilterVertices)(v, predicted, n, p);
}

}  // namespace carat::kernel
#endif  // HWY_ONCE
