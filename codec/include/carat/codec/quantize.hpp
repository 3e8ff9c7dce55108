// The near-lossless quantiser.
#pragma once

#include <cstdint>

namespace carat {

// Greatest radius r with r q + q/2 <= tolerance: floor(tolerance/q - 1/2). Throws Error(usage) if tolerance <
// q/2 or anything is not finite and positive, Error(limit) if r exceeds 2^29.
std::int32_t quantizer_radius(double tolerance, double quantum);

// The default quantum: the largest power of two not above min(2^-8 m, tolerance/8).
double default_quantum(double tolerance);

// Residual modulo 2^32 as a signed number, and its inverse: total on all of int32.
constexpr std::int32_t wrapping_sub(std::int32_t a, std::int32_t b) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}
constexpr std::int32_t wrapping_add(std::int32_t a, std::int32_t b) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}
constexpr std::int32_t wrapping_mul(std::int32_t a, std::int32_t b) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) * static_cast<std::uint32_t>(b));
}

// Index of the multiple of 2r + 1 nearest to the residual: |residual - index (2r + 1)| <= r.
constexpr std::int32_t quantize(std::int32_t residual, std::int32_t radius) {
    const std::int64_t step = 2 * std::int64_t{radius} + 1, r = residual;
    return static_cast<std::int32_t>(r >= 0 ? (r + radius) / step : -((radius - r) / step));
}
constexpr std::int32_t dequantize(std::int32_t index, std::int32_t radius) {
    return wrapping_mul(index, 2 * radius + 1);
}

}  // namespace carat
