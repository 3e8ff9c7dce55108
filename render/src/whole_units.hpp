// Doubles to whole numbers, halves to even, in two operations that every vector unit has.
#pragma once

#include <bit>
#include <cstdint>

namespace carat {

// 1.5 * 2^52: the sum with a double below 2^51 has that rounded to a whole number in its lowest bits.
inline constexpr double kWholeInMantissa = 6755399441055744.0;

// |x| < 2^51; beyond, a pure function of x all the same.
inline std::int64_t nearest_whole(double x) {
    return static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(x + kWholeInMantissa) -
                                     std::bit_cast<std::uint64_t>(kWholeInMantissa));
}

}  // namespace carat
