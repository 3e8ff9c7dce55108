// Elias-gamma codes of signed values: x = zigzag(v) + 1 as floor(log2 x) zero bits, a one bit, the low bits
// of x.
#pragma once

#include <bit>
#include <cstdint>

#include "bits.hpp"

namespace carat {

constexpr std::uint64_t gamma_of(std::int32_t v) {
    const std::int64_t wide = v;
    return static_cast<std::uint64_t>(wide >= 0 ? 2 * wide : -2 * wide - 1) + 1;
}

constexpr std::int32_t value_of_gamma(std::uint64_t code) {
    const std::uint64_t z = code - 1;
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(z >> 1) ^
                                     (0u - static_cast<std::uint32_t>(z & 1)));
}

template <class Sink>
void put_gamma(Sink& out, std::int32_t value) {
    const std::uint64_t code = gamma_of(value);
    const int n = static_cast<int>(std::bit_width(code)) - 1;
    out.put(std::uint64_t{1} << n, n + 1);
    out.put(code ^ std::uint64_t{1} << n, n);
}

// Throws Error(corrupt) for codes of no int32, Error(truncated) past the end of the bits.
inline std::int32_t take_gamma(BitReader& in) {
    in.refill();
    const int zeros = std::countr_zero(in.peek());
    if (zeros <= 27) {  // the whole code is buffered
        in.skip(zeros + 1);
        return value_of_gamma((std::uint64_t{1} << zeros) | in.take(zeros));
    }
    if (zeros > 32) {
        if (in.overrun() || in.peek() == 0) throw Error(ErrorCode::truncated, "gamma code ends early");
        throw Error(ErrorCode::corrupt, "gamma code above 2^32");
    }
    in.skip(zeros + 1);
    in.refill();
    const std::uint64_t code = (std::uint64_t{1} << zeros) | in.take(zeros);
    if (code > (std::uint64_t{1} << 32)) throw Error(ErrorCode::corrupt, "gamma code above 2^32");
    return value_of_gamma(code);
}

}  // namespace carat
