// From a place to the half that contains it, on every level.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "carat/globe/ellipsoid.hpp"
#include "carat/globe/locate.hpp"
#include "design_diamond.hpp"
#include "reference_math.hpp"

namespace carat::test {
namespace {

constexpr auto kExtent = static_cast<double>(kLatticeExtent);
// Rounding of a coordinate in [0, 2^31], in lattice units; 4 nm on Earth.
constexpr double kRounding = 0x1p-20;

RealLattice at(double latitude, double longitude) {
    return lattice_position(direction(Geodetic{latitude, longitude}));
}

// Poles, antimeridian, prime meridian, cube edges and corners, and their surroundings at all distances.
std::vector<RealLattice> places(Random& random) {
    std::vector<RealLattice> out;
    for (int n = 0; n < 1500; ++n) out.push_back(lattice_position(random_normal(random)));
    for (int n = 0; n < 1500; ++n) {
        const Vec3 v = direction(random_target(random));
        const double away = std::pow(10.0, random.real(-17, -1));
        const Vec3 to = random_normal(random);
        out.push_back(lattice_position({v[0] + away * to[0], v[1] + away * to[1], v[2] + away * to[2]}));
    }
    for (const double latitude : {90.0, 89.9999999999, 45.0, 35.264389682754654, 1e-13, 0.0, -60.0, -90.0})
        for (const double longitude : {-180.0, -179.9999999999, -135.0, -45.0, 0.0, 1e-13, 45.0, 90.0, 180.0})
            out.push_back(at(latitude, longitude));
    return out;
}

// Distance of a location from the border of its half in lattice units, positive inside.
double depth(const Location& l) {
    const HalfFrame f = half_frame(l.half, 1);
    const double leg = static_cast<double>(length(wide_real(narrow(f.u))));
    const double high = l.half.side == 0 ? l.s : l.t, low = l.half.side == 0 ? l.t : l.s;
    return leg * std::min({1 - high, low, (high - low) / std::numbers::sqrt2});
}

Real3 point(const Location& l) {
    const HalfFrame f = half_frame(l.half, 1);
    const auto wide3 = [](const LatticeVector& v) {
        return Real3{static_cast<Real>(v.x), static_cast<Real>(v.y), static_cast<Real>(v.z)};
    };
    return wide3(f.origin) + static_cast<Real>(l.s) * wide3(f.u) + static_cast<Real>(l.t) * wide3(f.v);
}

template <class Visit>
void for_places(Visit visit) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const RealLattice& place : places(random))
        for (int level = 0; level <= kDeepestId; ++level) visit(place, locate(place, level), level);
}

TEST(Locate, NamesAHalfOfTheLevelWithIndicesInRange) {
    for_places([](const RealLattice&, const Location& l, int level) {
        ASSERT_EQ(l.half.diamond.level(), level);
        ASSERT_TRUE(DiamondId::parse(l.half.diamond.bits()));
        ASSERT_TRUE(l.half.side == 0 || l.half.side == 1);
        ASSERT_GE(std::min(l.s, l.t), 0);
        ASSERT_LE(std::max(l.s, l.t), 1);
        ASSERT_TRUE(l.half.side == 0 ? l.s >= l.t : l.s <= l.t) << l.s << ' ' << l.t;
    });
}

TEST(Locate, IndicesGiveThePlaceBack) {
    double worst = 0;
    for_places([&](const RealLattice& place, const Location& l, int) {
        const double off = static_cast<double>(length(point(l) - wide_real(place.coordinates)));
        ASSERT_LT(off, kRounding) << ::testing::PrintToString(l.half);
        worst = std::max(worst, off);
    });
    std::cout << "place and its indices differ by at most " << worst << " lattice units\n";
}

TEST(Locate, TheHalfIsOnTheFaceOfThePlace) {
    for_places([](const RealLattice& place, const Location& l, int level) {
        const DesignDiamond d = design_diamond(l.half.diamond.centre(), level);
        ASSERT_EQ(d.face[static_cast<std::size_t>(l.half.side)], place.face);
    });
}

TEST(Locate, AFinerHalfIsAChildOfTheCoarserOne) {
    int checked = 0;
    for_places([&](const RealLattice& place, const Location& l, int level) {
        if (level == kDeepestId) return;
        const Location finer = locate(place, level + 1);
        if (depth(l) < kRounding || depth(finer) < kRounding) return;  // rounding decides on a border
        ASSERT_EQ(parent_half(finer.half), l.half) << to_string(l.half.diamond);
        ++checked;
    });
    EXPECT_GT(checked, 50'000);
}

// Descending by child halves with locate_in alone reaches a half that holds the place, and away from borders
// the same one.
TEST(Locate, AgreesWithDescendingByChildHalves) {
    Random random;
    SCOPED_TRACE(random.trace());
    int same = 0;
    for (const RealLattice& place : places(random)) {
        Half h = locate(place, 0).half;
        for (int level = 1; level <= kDeepestId; ++level) {
            const std::array<Half, 2> k = child_halves(h);
            h = depth(locate_in(place, k[0])) >= depth(locate_in(place, k[1])) ? k[0] : k[1];
            const Location in = locate_in(place, h);
            ASSERT_GT(depth(in), -kRounding) << ::testing::PrintToString(h);
            const Location direct = locate(place, level);
            if (std::min(depth(in), depth(direct)) > kRounding) {
                ASSERT_EQ(direct.half, h);
                ASSERT_LT(static_cast<double>(length(point(in) - point(direct))), kRounding);
                ++same;
            }
        }
    }
    EXPECT_GT(same, 50'000);
}

TEST(Locate, NoNeighbourHoldsAPlaceThatIsInside) {
    for_places([](const RealLattice& place, const Location& l, int level) {
        if (level % 5 != 0 || depth(l) < kRounding) return;
        for (int e = 0; e < 3; ++e) {
            const Half n = neighbour(l.half, e);
            const DesignDiamond d = design_diamond(n.diamond.centre(), level);
            if (d.face[static_cast<std::size_t>(n.side)] != place.face) continue;
            ASSERT_LT(depth(locate_in(place, n)), 0) << to_string(n.diamond);
        }
    });
}

TEST(Locate, LatticePointsFallOnTheirOwnIndices) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int n = 0; n < 20'000; ++n) {
        const int level = static_cast<int>(random.integer(0, kDeepestId));
        const Half h{random_diamond(random, level), n % 2};
        const int high = static_cast<int>(random.integer(1, 64)),
                  low = static_cast<int>(random.integer(0, high));
        const int i = h.side == 0 ? high : low, j = h.side == 0 ? low : high;
        const LatticePoint p = half_frame(h, 64).vertex(i, j);
        const DesignDiamond d = design_diamond(h.diamond.centre(), level);
        const RealLattice place{
            d.face[static_cast<std::size_t>(h.side)],
            {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)}};
        const Location in = locate_in(place, h);
        ASSERT_EQ(in.s * 64, i);
        ASSERT_EQ(in.t * 64, j);
        const Location found = locate(place, level);
        ASSERT_EQ(static_cast<double>(length(point(found) - wide_real(p))), 0);
        if (high < 64 && low > 0 && low < high) {
            ASSERT_EQ(found.half, h);
        }
    }
}

TEST(Locate, TheAntimeridianIsOneLine) {
    for (const double latitude : {-89.0, -45.0, 0.0, 12.5, 45.0, 77.7})
        for (int level = 0; level <= kDeepestId; ++level) {
            const Location west = locate(at(latitude, -180), level), east = locate(at(latitude, 180), level);
            EXPECT_EQ(west.half, east.half);
            EXPECT_EQ(west.s, east.s);
            EXPECT_EQ(west.t, east.t);
        }
}

TEST(Locate, PolesAreTheCentresOfTheirFaces) {
    for (const double s : {-1.0, 1.0})
        for (const double longitude : {-180.0, -33.0, 0.0, 90.0}) {
            const RealLattice pole = at(s * 90, longitude);
            EXPECT_EQ(pole.face, s > 0 ? 4 : 5);
            EXPECT_EQ(pole.coordinates, (Vec3{0, 0, s * kExtent}));
            const Location l = locate(pole, 0);
            EXPECT_EQ(l.half.diamond, root_diamond(pole.face));
            EXPECT_EQ(l.s, 0.5);
            EXPECT_EQ(l.t, 0.5);
        }
}

}  // namespace
}  // namespace carat::test
