// Distances from S against what they are by construction, and views that random_views.hpp makes.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "carat/bench/random_views.hpp"
#include "carat/bench/surface_distance.hpp"
#include "carat/globe/locate.hpp"
#include "render/cut/planets.hpp"

namespace carat::bench {
namespace {

std::shared_ptr<const Repository> borrow(const test::FakeRepository& repository) {
    return {std::shared_ptr<const void>(), &repository};
}

// A ball of constant height: the distance is the height above it, whichever way S curves.
TEST(SurfaceDistance, OverAPlainItIsTheHeightAbove) {
    const test::FakeRepository& ball = test::smooth_ball();
    const SurfaceDistance distance(borrow(ball));
    const double ground = ball.surface(Geodetic{10, 20});
    for (const double above : {-300.0, -1.0, 0.0, 0.5, 40.0, 5000.0}) {
        const Vec3 point = ball.body().position(direction(Geodetic{10, 20}), ground + above);
        EXPECT_NEAR(distance(point), std::abs(above), 1e-6) << above;
    }
}

// Hills of 600 m on a ball of 20 km: slopes to one in three.
const test::FakeRepository& hills() {
    static const test::FakeRepository& out = *new test::FakeRepository([] {
        test::FakeOptions o;
        o.body = Ellipsoid(20'000, 20'000);
        o.log2_cells = 4;
        o.depth = 5;
        o.relief = [](const Vec3& n) {
            return 600 * std::sin(8 * n[0]) * std::cos(7 * n[1] + 1) * std::sin(9 * n[2] + 2);
        };
        return o;
    }());
    return out;
}

// Never more than straight down, never less than a dense search around.
TEST(SurfaceDistance, OverReliefItIsBetweenTheNearestPointAndTheOneBeneath) {
    const test::FakeRepository& ball = hills();
    const SurfaceDistance distance(borrow(ball));
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> sign(-1, 1);
    double gained = 0;
    for (int k = 0; k < 60; ++k) {
        const Geodetic at{70 * sign(random), 170 * sign(random)};
        const double above = 100 * sign(random);
        const Vec3 point = ball.body().position(direction(at), ball.surface(at) + above);
        double nearest = std::abs(above);
        constexpr double kStep = 3.0 / 20'000 * 57.2958;  // 3 m
        for (int i = -20; i <= 20; ++i)
            for (int j = -20; j <= 20; ++j) {
                const Geodetic there{at.latitude + i * kStep,
                                     at.longitude + j * kStep / std::cos(at.latitude / 57.2958)};
                const Vec3 s = ball.body().position(direction(there), ball.surface(there));
                nearest = std::min(nearest, std::hypot(s[0] - point[0], s[1] - point[1], s[2] - point[2]));
            }
        const double found = distance(point);
        EXPECT_LE(found, std::abs(above) + 1e-6);
        EXPECT_GE(found, nearest - 0.3) << "the search is 3 m coarse";
        EXPECT_LE(found, nearest + 2) << "and the step finds nearly the nearest";
        gained = std::max(gained, 1 - found / std::max(1.0, std::abs(above)));
    }
    EXPECT_GT(gained, 0.01) << "on slopes the nearest point is not the one beneath";
}

TEST(RandomViews, AreTheSameForASeedAndAboveTheGround) {
    const test::FakeRepository& earth = test::rough_earth();
    RandomViews one(borrow(earth), 7, 64, 48), two(borrow(earth), 7, 64, 48);
    int low = 0, high = 0;
    for (int k = 0; k < 200; ++k) {
        const ViewRequest a = one.next(), b = two.next();
        EXPECT_EQ(a.eye.latitude, b.eye.latitude);
        EXPECT_EQ(a.height, b.height);
        const double above = a.height - earth.surface(a.eye);
        EXPECT_GE(above, 2.9);
        low += above < 20 ? 1 : 0;
        high += above > 1e6 ? 1 : 0;
        EXPECT_NO_THROW((void)make_camera(earth.body(), a));
    }
    EXPECT_GT(low, 20);
    EXPECT_GT(high, 10);
}

TEST(ErrorSpread, OfKnownValues) {
    std::vector<double> values(1000, 1);
    values[3] = 5;
    const ErrorSpread s = error_spread(values);
    EXPECT_EQ(s.max, 5);
    EXPECT_EQ(s.p999, 1);
    EXPECT_NEAR(s.rms, std::sqrt(1.024), 1e-12);
    EXPECT_EQ(error_spread({}).max, 0);
}

}  // namespace
}  // namespace carat::bench
