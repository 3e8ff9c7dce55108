// DiamondId::parse takes any 64 bits: it names a diamond whose id is those very bits, or nothing.
#include <gtest/gtest.h>

#include <bit>

#include "carat/globe/diamond.hpp"
#include "diamond_levels.hpp"

namespace carat::test {
namespace {

// Counts acceptance, so that a parser that refuses everything fails too.
struct Outcome {
    int accepted = 0, refused = 0;
};

void parse(std::uint64_t bits, Outcome& outcome) {
    const std::optional<DiamondId> d = DiamondId::parse(bits);
    ++(d ? outcome.accepted : outcome.refused);
    if (!d) return;
    ASSERT_EQ(d->bits(), bits);
    ASSERT_GE(d->level(), 0);
    ASSERT_LE(d->level(), kDeepestId);
    ASSERT_TRUE(on_lattice(wide(d->centre()))) << std::hex << bits;
    ASSERT_EQ(DiamondId::of_centre(d->centre()).bits(), bits)
        << "two ids of one diamond: " << std::hex << bits;
    ASSERT_EQ(diamond_at(d->centre()), d);
    const DiamondCorners k = corners(*d);
    for (const LatticePoint& p : {k.a, k.b, k.x[0], k.x[1], k.c})
        ASSERT_TRUE(on_lattice(wide(p))) << std::hex << bits;
}

TEST(DiamondIdParse, AnyBits) {
    Random random;
    SCOPED_TRACE(random.trace());
    Outcome outcome;
    for (int n = 0; n < 300'000; ++n) ASSERT_NO_FATAL_FAILURE(parse(random.bits(), outcome));
    EXPECT_GT(outcome.refused, 0);
}

TEST(DiamondIdParse, BitsWithAFaceInRange) {
    Random random;
    SCOPED_TRACE(random.trace());
    Outcome outcome;
    for (int n = 0; n < 300'000; ++n) {
        std::uint64_t bits = random.bits() >> 7;                // faces 0 to 7
        if (n % 2 == 0) bits &= ~std::uint64_t{0} << (n % 60);  // coarse levels
        if (n % 3 == 0) bits &= random.bits() & random.bits();  // few bits set
        ASSERT_NO_FATAL_FAILURE(parse(bits, outcome));
    }
    EXPECT_GT(outcome.accepted, 10'000);
    EXPECT_GT(outcome.refused, 10'000);
}

TEST(DiamondIdParse, OneBitSetOrCleared) {
    Outcome outcome;
    for (int k = 0; k < 64; ++k) {
        parse(std::uint64_t{1} << k, outcome);
        parse(~(std::uint64_t{1} << k), outcome);
    }
    parse(0, outcome);
    parse(~std::uint64_t{0}, outcome);
    EXPECT_FALSE(DiamondId::parse(~std::uint64_t{0})) << "the id that names no diamond";
    EXPECT_FALSE(DiamondId::parse(DiamondId{}.bits()));
    EXPECT_FALSE(DiamondId::parse(0)) << "a cube corner";
}

TEST(DiamondIdParse, FlippedBitsOfGoodIds) {
    Outcome outcome;
    for_random(kDeepestId, [&](DiamondId d, int) {
        for (int k = 0; k < 64; ++k) parse(d.bits() ^ (std::uint64_t{1} << k), outcome);
    });
    EXPECT_GT(outcome.accepted, 0);
    EXPECT_GT(outcome.refused, 0);
}

// Complete as well as sound: of all bits that could name a diamond of levels 0 to 6, exactly those that do
// are taken.
TEST(DiamondIdParse, AcceptsExactlyTheDiamondsOfTheFirstLevels) {
    constexpr int kLevels = 6;  // centres are multiples of 2^(30 - 3) in shifted coordinates
    constexpr int kFree = 2 * 5;
    std::set<DiamondId> accepted;
    for (std::uint64_t face = 0; face < 1024; ++face)
        for (std::uint64_t morton = 0; morton < (1u << kFree); ++morton)
            if (const auto d = DiamondId::parse((face << 54) | (morton << (54 - kFree))))
                if (d->level() <= kLevels) accepted.insert(*d);
    std::set<DiamondId> expected;
    for_all([&](DiamondId d, int level) {
        if (level <= kLevels) expected.insert(d);
    });
    EXPECT_EQ(accepted, expected);
}

}  // namespace
}  // namespace carat::test
