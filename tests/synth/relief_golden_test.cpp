// The formulas are pinned: a change of any height by a millimetre shows here. They use only operations that
// IEEE 754 fixes, so the numbers hold for every compiler; change them only with the formula, and say so.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "carat/synth/synth.hpp"

namespace carat::synth {
namespace {

/// A few hundred directions from integers alone.
std::array<double, 3> direction_of(int i) {
    const auto coordinate = [i](std::int64_t prime) { return static_cast<double>(i * prime % 1999) - 999.5; };
    const double x = coordinate(7919), y = coordinate(104729), z = coordinate(15485863);
    const double l = std::sqrt(x * x + y * y + z * z);
    return {x / l, y / l, z / l};
}

/// FNV-1a of the bits of heights.
std::uint64_t hash_of(const Height& height) {
    std::uint64_t hash = 0xcbf29ce484222325ULL;
    for (int i = 0; i < 400; ++i) {
        const auto bits = std::bit_cast<std::uint64_t>(height(direction_of(i)));
        for (int byte = 0; byte < 8; ++byte) hash = (hash ^ (bits >> (8 * byte) & 0xff)) * 0x100000001b3ULL;
    }
    return hash;
}

TEST(ReliefGolden, EarthlikeHeightsAreTheRecordedOnes) {
    EXPECT_EQ(hash_of(earthlike(1, 20)), 0xd0ffbb8c76d10291ULL);
    EXPECT_EQ(hash_of(earthlike(1, 20000)), 0xcfb96909df1ba262ULL);
    EXPECT_EQ(hash_of(earthlike(0xfedcba9876543210ULL, 500)), 0x702532f46bbd0284ULL);
}

TEST(ReliefGolden, MoonlikeHeightsAreTheRecordedOnes) {
    EXPECT_EQ(hash_of(moonlike(1, 100)), 0xbea82b3910d7727bULL);
    EXPECT_EQ(hash_of(moonlike(2, 5000)), 0xe61447d2d368e643ULL);
}

}  // namespace
}  // namespace carat::synth
