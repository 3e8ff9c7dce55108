// The sweeps of carat bench stability, thinned: their bounds hold, and their reference is GeographicLib's.
#include <gtest/gtest.h>

#include <GeographicLib/Geocentric.hpp>
#include <algorithm>
#include <cmath>
#include <random>

#include "carat/bench/stability.hpp"
#include "carat/globe/patch.hpp"

namespace carat::bench {
namespace {

StabilityOptions small() {
    StabilityOptions o;
    o.small = true;
    o.vertices = 4;
    return o;
}

TEST(Stability, TheReferenceIsGeographicLibs) {
    std::mt19937_64 random(3);
    std::uniform_int_distribution<std::int32_t> any(-kLatticeExtent, kLatticeExtent);
    std::uniform_real_distribution<double> heights(-1e4, 1e5);
    const Ellipsoid earth = Ellipsoid::earth();
    for (int k = 0; k < 2000; ++k) {
        LatticePoint p{any(random), any(random), any(random)};
        (k % 3 == 0 ? p.x : k % 3 == 1 ? p.y : p.z) = k % 2 == 0 ? kLatticeExtent : -kLatticeExtent;
        const double height = heights(random);
        const Geodetic place = geodetic(direction(p));
        Vec3 theirs{};
        GeographicLib::Geocentric::WGS84().Forward(place.latitude, place.longitude, height, theirs[0],
                                                   theirs[1], theirs[2]);
        const LongVec3 ours = reference_position(earth, p, height);
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(static_cast<double>(ours[c]), theirs[c], 1e-8);
    }
}

TEST(Stability, PositionsAreWithinTheBoundEverywhere) {
    double worst = 0, nearest = 0;
    const std::vector<StabilityRow> rows = measure_stability(small());
    EXPECT_GT(rows.size(), 1000u);
    for (const StabilityRow& r : rows) {
        EXPECT_LE(r.share, 1) << r.body << ", " << r.place << ", level " << r.level << ", " << r.altitude
                              << " m up";
        worst = std::max(worst, r.share);
        if (r.body == "Earth") nearest = std::max(nearest, r.near_error);
    }
    EXPECT_GT(worst, 0.3) << "a bound that nothing comes near says little";
    EXPECT_LE(nearest, 12e-6) << "metres within 10 m of the eye, on Earth";
    EXPECT_GT(nearest, 0) << "no vertex was within 10 m";
}

TEST(Stability, AnEyeThatCreepsSeesVerticesFollow) {
    for (const JitterRow& r : measure_jitter(small())) {
        EXPECT_LE(r.step, r.bound) << r.body << ", " << r.place;
        EXPECT_GT(r.step, 0) << r.body << ", " << r.place << ": nothing was measured";
        if (r.body == "Earth") {
            EXPECT_LE(r.step, 26) << r.place << ": micrometres within 10 m";
        }
    }
}

TEST(Stability, DepthTellsACentimetreApartAtTenMetresAndSwapsNothing) {
    bool ten_metres = false;
    for (const DepthRow& r : measure_depth(small())) {
        EXPECT_GT(r.separation, 0) << r.distance;
        EXPECT_LE(r.separation, std::max(1e-6 * r.distance, 1e-4)) << r.distance;
        EXPECT_EQ(r.swapped, 0u) << r.distance;
        if (r.distance == 10) {
            ten_metres = true;
            EXPECT_LE(r.separation, 0.01);
        }
    }
    EXPECT_TRUE(ten_metres);
}

}  // namespace
}  // namespace carat::bench
