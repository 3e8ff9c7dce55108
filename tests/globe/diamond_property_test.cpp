// The diamond DAG against the design's own words (design_diamond.hpp): exhaustive to level 9, then at random
// to the deepest level.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "carat/globe/diamond.hpp"
#include "design_diamond.hpp"
#include "diamond_levels.hpp"

namespace carat::test {
namespace {

std::set<LatticePoint> as_set(const std::array<LatticeVector, 4>& points) {
    std::set<LatticePoint> out;
    for (const LatticeVector& p : points) out.insert(narrow(p));
    return out;
}

TEST(Diamond, EveryLevelHasSixTimesTwoToTheLevel) {
    for (std::size_t l = 0; l <= kExhaustive; ++l) EXPECT_EQ(all_levels()[l].size(), 6u << l);
}

void expect_identity(DiamondId d, int level) {
    EXPECT_EQ(d.level(), level);
    const std::optional<DiamondId> parsed = DiamondId::parse(d.bits());
    ASSERT_TRUE(parsed) << to_string(d);
    EXPECT_EQ(*parsed, d);
    EXPECT_EQ(DiamondId::of_centre(d.centre()), d);
    EXPECT_EQ(diamond_at(d.centre()), d);
    EXPECT_EQ(d.face(), faces_of(wide(d.centre())).front());
}

TEST(Diamond, IdNamesCentreAndLevel) {
    for_all(expect_identity);
    for_random(kDeepestId, expect_identity);
}

TEST(Diamond, IdsOfTheExhaustiveLevelsAreUnique) {
    std::set<std::uint64_t> bits;
    std::set<LatticePoint> centres;
    std::size_t count = 0;
    for_all([&](DiamondId d, int) {
        bits.insert(d.bits());
        centres.insert(d.centre());
        ++count;
    });
    EXPECT_EQ(bits.size(), count);
    EXPECT_EQ(centres.size(), count);
}

TEST(Diamond, NoneIsCentredOnACubeCornerOrOffTheLattice) {
    const auto e = static_cast<std::int32_t>(kLatticeExtent);
    for (const int x : {-e, e})
        for (const int y : {-e, e})
            for (const int z : {-e, e}) EXPECT_FALSE(diamond_at({x, y, z})) << x << ' ' << y << ' ' << z;
    EXPECT_FALSE(diamond_at({0, 0, 0}));
    EXPECT_FALSE(diamond_at({e - 1, 64, 64}));
    EXPECT_FALSE(diamond_at({INT32_MAX, e, 0}));
    EXPECT_FALSE(diamond_at({INT32_MIN, INT32_MIN, INT32_MIN}));
    EXPECT_FALSE(diamond_at({e, 1, 1}));  // level 60
    EXPECT_FALSE(diamond_at({e, 0, 32})) << "level 51";
    EXPECT_EQ(diamond_at({e, 32, 32})->level(), 50);
}

void expect_design_corners(DiamondId d, int level) {
    const DiamondCorners k = corners(d);
    const DesignDiamond design = design_diamond(d.centre(), level);
    EXPECT_EQ(k.level, level);
    EXPECT_EQ(k.c, narrow(design.c)) << to_string(d);
    EXPECT_EQ(k.a, narrow(design.a)) << to_string(d);
    EXPECT_EQ(k.b, narrow(design.b)) << to_string(d);
    EXPECT_EQ(k.x[0], narrow(design.x[0])) << to_string(d);
    EXPECT_EQ(k.x[1], narrow(design.x[1])) << to_string(d);
    std::set<LatticePoint> centres;
    for (int i = 0; i < 4; ++i) centres.insert(k.child_centre(i));
    EXPECT_EQ(centres, as_set(design.children)) << to_string(d);
}

TEST(Diamond, CornersAndChildCentresAreThoseOfTheDesign) {
    for_all(expect_design_corners);
    for_random(kDeepestId, expect_design_corners);
}

// Even levels from 2: a is a corner of the square two levels coarser, b that square's centre.
TEST(Diamond, EvenDiagonalRunsFromTheCoarserSquaresCornerToItsCentre) {
    const auto check = [](DiamondId d, int level) {
        if (level % 2 != 0 || level == 0) return;
        const DiamondCorners k = corners(d);
        const std::optional<DiamondId> coarser = diamond_at(k.b);
        ASSERT_TRUE(coarser);
        EXPECT_EQ(coarser->level(), level - 2);
        const DiamondCorners q = corners(*coarser);
        const std::set<LatticePoint> square{q.a, q.b, q.x[0], q.x[1]};
        EXPECT_EQ(square.count(k.a), 1u) << to_string(d);
    };
    for_all(check);
    for_random(kDeepestId, check);
}

TEST(Diamond, FourDistinctChildrenOneLevelFiner) {
    const auto check = [](DiamondId d, int level) {
        const std::array<DiamondId, 4> k = children(d);
        EXPECT_EQ(std::set<DiamondId>(k.begin(), k.end()).size(), 4u) << to_string(d);
        for (int i = 0; i < 4; ++i) {
            EXPECT_EQ(k[static_cast<std::size_t>(i)], child(d, i));
            EXPECT_EQ(child(d, i).level(), level + 1);
        }
    };
    for_all(check);
    for_random(kDeepestId - 1, check);
}

TEST(Diamond, ExactlyTwoParentsAndTheRelationIsMutual) {
    std::map<DiamondId, std::set<DiamondId>> parents_of;
    for_all([&](DiamondId d, int) {
        for (const DiamondId k : children(d)) parents_of[k].insert(d);
    });
    for_all([&](DiamondId d, int level) {
        if (level == 0) {
            EXPECT_FALSE(parent(d, 0) || parent(d, 1));
            return;
        }
        const std::set<DiamondId> expected = parents_of.at(d);
        EXPECT_EQ(expected.size(), 2u) << to_string(d);
        EXPECT_EQ((std::set{parent(d, 0).value(), parent(d, 1).value()}), expected) << to_string(d);
    });
}

TEST(Diamond, ParentAndChildAreMutualAtAllLevels) {
    const auto check = [](DiamondId d, int level) {
        for (int h = 0; h < 2 && level > 0; ++h) {
            const DiamondId p = parent(d, h).value();
            EXPECT_EQ(p.level(), level - 1);
            const std::array<DiamondId, 4> k = children(p);
            EXPECT_EQ(std::count(k.begin(), k.end(), d), 1) << to_string(d);
            EXPECT_EQ(half_in_parent(d, p), h) << to_string(d);
            EXPECT_EQ(p.centre(), corners(d).x[static_cast<std::size_t>(h)]);
        }
        if (level > 0) {
            EXPECT_NE(parent(d, 0), parent(d, 1)) << to_string(d);
        }
        if (level == kDeepestId) return;
        for (const DiamondId k : children(d))
            EXPECT_TRUE(parent(k, 0) == d || parent(k, 1) == d) << to_string(d);
    };
    for_all(check);
    for_random(kDeepestId, check);
}

// Morton order: all ids of one square of a level share their leading bits, so a square is one range of ids.
TEST(Diamond, QuartersOfASquareShareTheLeadingBitsOfItsId) {
    const auto check = [](DiamondId d, int level) {
        if (level % 2 != 0 || level + 2 > kDeepestId) return;
        for (const int side : {0, 1})
            for (const Half& k : child_halves({d, side}))
                for (const Half& quarter : child_halves(k))
                    EXPECT_EQ(quarter.diamond.bits() >> (52 - level), d.bits() >> (52 - level))
                        << to_string(d) << ' ' << to_string(quarter.diamond);
    };
    for_all(check);
    for_random(kDeepestId, check);
}

}  // namespace
}  // namespace carat::test
