// Pages and slots: every diamond has one page and one slot in it; slots name their diamonds; keys name their
// squares.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "census.hpp"
#include "globe/design_diamond.hpp"
#include "globe/diamond_levels.hpp"
#include "page_layout.hpp"

namespace carat::test {
namespace {

constexpr int kLevels = 8;  // exhaustive to here

void expect_round_trip(DiamondId d) {
    const PageSlot at = page_slot(d);
    const std::optional<DiamondId> square = page_square(at.key);
    ASSERT_TRUE(square.has_value()) << to_string(d);
    ASSERT_GE(at.slot, 0);
    ASSERT_LT(at.slot, kPageSlots);
    ASSERT_EQ(slot_diamond(*square, at.slot), d) << to_string(d);
    ASSERT_EQ(square->level(), d.level() - d.level() % kBandLevels);
    ASSERT_EQ(page_key(*square), at.key);
    ASSERT_EQ(at.key >> 57, static_cast<std::uint64_t>(d.level() / kBandLevels));
}

TEST(PageLayout, EveryDiamondHasOneSlotThatNamesIt) {
    std::set<std::pair<PageKey, int>> taken;
    for (std::size_t l = 0; l <= kLevels; ++l)
        for (const DiamondId d : all_levels()[l]) {
            expect_round_trip(d);
            const PageSlot at = page_slot(d);
            ASSERT_TRUE(taken.insert({at.key, at.slot}).second) << to_string(d);
        }
}

TEST(PageLayout, DeepDiamondsToo) {
    for_random(kDeepestId, [](DiamondId d, int) { expect_round_trip(d); });
}

TEST(PageLayout, ASlotOfAnotherPageNamesADiamondOfTheSquaresClosure) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int k = 0; k < 2000; ++k) {
        const int band = static_cast<int>(random.integer(0, 8));
        const DiamondId square = random_diamond(random, band * kBandLevels);
        std::set<DiamondId> seen;
        for (int slot = 0; slot < kPageSlots; ++slot) {
            const int j = slot < 1 ? 0 : slot < 5 ? 1 : slot < 9 ? 2 : slot < 21 ? 3 : slot < 37 ? 4 : 5;
            if (square.level() + j > kDeepestId) break;
            const DiamondId d = slot_diamond(square, slot);
            EXPECT_TRUE(seen.insert(d).second);
            EXPECT_EQ(d.level(), square.level() + j);
            const PageSlot own = page_slot(d);
            if (own.key == page_key(square)) {
                EXPECT_EQ(own.slot, slot);
            } else {
                EXPECT_LT(page_square(own.key)->bits(), square.bits()) << "a tie goes to the smaller id";
            }
            const std::int64_t half = half_size(square.level());
            const LatticeVector away = wide(d.centre()) - wide(square.centre());
            for (int axis = 0; axis < 3; ++axis) EXPECT_LE(std::abs(away[axis]), half);
        }
    }
}

// By counting: levels j odd have sides shared by two squares, each owned once.
TEST(PageLayout, OwnSlotsAddUpToTheLevel) {
    for (const std::size_t top : {0u, 6u}) {
        std::map<int, std::uint64_t> own;  // by sub-level
        for (const DiamondId square : all_levels()[top])
            for (int slot = 0; slot < kPageSlots; ++slot)
                if (page_slot(slot_diamond(square, slot)).key == page_key(square))
                    ++own[slot_diamond(square, slot).level() - square.level()];
        for (int j = 0; j < kBandLevels; ++j) EXPECT_EQ(own[j], 6ull << (static_cast<int>(top) + j)) << j;
    }
}

TEST(PageLayout, ParentPageContainsTheSquare) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int band = 0; band <= 8; ++band)
        for (int k = 0; k < 300; ++k) {
            const DiamondId square = random_diamond(random, band * kBandLevels);
            const std::optional<PageKey> up = parent_page(page_key(square));
            ASSERT_EQ(up.has_value(), band > 0);
            if (!up) continue;
            const DiamondId coarse = *page_square(*up);
            EXPECT_EQ(coarse.level(), square.level() - kBandLevels);
            EXPECT_EQ(coarse.face(), square.face());
            const LatticeVector away = wide(square.centre()) - wide(coarse.centre());
            for (int axis = 0; axis < 3; ++axis)
                EXPECT_LE(std::abs(away[axis]), axis == face_axis(square.face())
                                                    ? 0
                                                    : half_size(coarse.level()) - half_size(square.level()));
        }
}

TEST(PageLayout, KeysThatNameNoSquareAreFound) {
    Random random;
    SCOPED_TRACE(random.trace());
    int named = 0;
    for (int k = 0; k < 100000; ++k) {
        const PageKey key = k % 2 == 0
                                ? random.bits()
                                : page_key(root_diamond(k % 6)) ^ (std::uint64_t{1} << random.integer(0, 63));
        const std::optional<DiamondId> square = page_square(key);
        if (!square) continue;
        ++named;
        EXPECT_EQ(page_key(*square), key);
        EXPECT_EQ(square->level() % kBandLevels, 0);
    }
    EXPECT_LT(named, 50000);
    EXPECT_FALSE(page_square(~PageKey{0}));
    EXPECT_FALSE(page_square((PageKey{1} << 57) | root_diamond(0).bits()));  // a level-0 square in band 1
}

// A page of a few bytes can stand for 2^50 diamonds.
TEST(ZeroPages, VisitingEndsWhereAskedTo) {
    int visited = 0;
    EXPECT_FALSE(
        visit_zero_diamonds(page_key(root_diamond(0)), 50, [&](DiamondId) { return ++visited < 1000; }));
    EXPECT_EQ(visited, 1000);
    visited = 0;
    EXPECT_TRUE(visit_zero_diamonds(page_key(root_diamond(0)), 1, [&](DiamondId) { return ++visited > 0; }));
    EXPECT_EQ(visited, 1);
}

}  // namespace
}  // namespace carat::test
