// Properties of the formulas: determinism, range, share of sea, no seam or pinch anywhere, nested octaves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "carat/globe/error.hpp"
#include "carat/synth/synth.hpp"

namespace carat::synth {
namespace {

using Vector = std::array<double, 3>;

Vector unit(double x, double y, double z) {
    const double l = std::sqrt(x * x + y * y + z * z);
    return {x / l, y / l, z / l};
}

Vector at(double latitude, double longitude) {
    const double a = longitude * std::numbers::pi / 180, b = latitude * std::numbers::pi / 180;
    return {std::cos(b) * std::cos(a), std::cos(b) * std::sin(a), std::sin(b)};
}

/// Points spread evenly over the sphere (Fibonacci lattice).
std::vector<Vector> even_points(int count) {
    std::vector<Vector> points;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count;
        const double turn = 2 * std::numbers::pi * i / std::numbers::phi;
        const double r = std::sqrt(1 - z * z);
        points.push_back({r * std::cos(turn), r * std::sin(turn), z});
    }
    return points;
}

double share_of_sea(const Height& height, int count) {
    int sea = 0;
    for (const Vector& n : even_points(count)) sea += height(n) < 0;
    return static_cast<double>(sea) / count;
}

TEST(ReliefProperty, EarthlikeStaysInItsRangeAndUsesIt) {
    for (const std::uint64_t seed : {1ULL, 2ULL, 77ULL}) {
        const Height height = earthlike(seed, 2000);
        double low = 0, high = 0;
        for (const Vector& n : even_points(20000)) {
            const double h = height(n);
            ASSERT_GT(h, -10800);
            ASSERT_LT(h, 8500);
            low = std::min(low, h);
            high = std::max(high, h);
        }
        EXPECT_LT(low, -7500) << "no trench, seed " << seed;
        EXPECT_GT(high, 4000) << "no range, seed " << seed;
    }
}

TEST(ReliefProperty, EarthlikeIsTwoThirdsToThreeQuartersSea) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const double share = share_of_sea(earthlike(seed, 20000), 5000);
        EXPECT_GT(share, 0.65) << "seed " << seed;
        EXPECT_LT(share, 0.75) << "seed " << seed;
    }
}

TEST(ReliefProperty, EarthlikeHasContinentsAndAbyss) {
    // Earth's hypsometry has two humps: near sea level and near -4500 m, with little between.
    const Height height = earthlike(1, 20000);
    int abyss = 0, slope = 0, plain = 0;
    for (const Vector& n : even_points(10000)) {
        const double h = height(n);
        abyss += h > -6000 && h < -3500;
        slope += h > -3000 && h < -500;
        plain += h > -200 && h < 1000;
    }
    EXPECT_GT(abyss, 1.7 * slope);
    EXPECT_GT(plain, 1.3 * slope);
}

TEST(ReliefProperty, MoonlikeStaysInItsRangeAndUsesIt) {
    const Height height = moonlike(1, 2000);
    double low = 0, high = 0;
    for (const Vector& n : even_points(20000)) {
        const double h = height(n);
        ASSERT_GT(h, -9500);
        ASSERT_LT(h, 10500);
        low = std::min(low, h);
        high = std::max(high, h);
    }
    EXPECT_LT(low, -4000);
    EXPECT_GT(high, 2000);
}

TEST(ReliefProperty, SameArgumentsSameBits) {
    const Height a = earthlike(5, 100), b = earthlike(5, 100), m = moonlike(5, 100), k = moonlike(5, 100);
    for (const Vector& n : even_points(500)) {
        EXPECT_EQ(a(n), b(n));
        EXPECT_EQ(a(n), earthlike_height(n, 5, 100));
        EXPECT_EQ(m(n), k(n));
        EXPECT_EQ(m(n), moonlike_height(n, 5, 100));
    }
}

TEST(ReliefProperty, SeedsGiveDifferentPlanets) {
    const Height a = earthlike(1, 20000), b = earthlike(2, 20000);
    int agree = 0;
    for (const Vector& n : even_points(1000)) agree += (a(n) < 0) == (b(n) < 0);
    // Two independent coasts with 70 % sea agree at 58 % of places.
    EXPECT_LT(agree, 750);
}

TEST(ReliefProperty, CoarserFormulasDifferOnlyInFineOctaves) {
    const Height fine = earthlike(3, 500), coarse = earthlike(3, 4000);
    double largest = 0, sum = 0;
    const std::vector<Vector> points = even_points(3000);
    for (const Vector& n : points) {
        const double d = std::abs(fine(n) - coarse(n));
        largest = std::max(largest, d);
        sum += d;
    }
    EXPECT_GT(largest, 1);
    EXPECT_LT(largest, 700);
    EXPECT_LT(sum / static_cast<double>(points.size()), 40);
}

/// The greatest difference of height over `step` metres, at points `p` in tangential directions.
double greatest_step(const Height& height, const std::vector<Vector>& points, double step, double radius) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> uniform(-1, 1);
    double greatest = 0;
    for (const Vector& p : points) {
        Vector d{uniform(random), uniform(random), uniform(random)};
        const double radial = d[0] * p[0] + d[1] * p[1] + d[2] * p[2];
        for (std::size_t k = 0; k < 3; ++k) d[k] -= radial * p[k];
        const Vector t = unit(d[0], d[1], d[2]);
        const double s = step / radius;
        const Vector q = unit(p[0] + s * t[0], p[1] + s * t[1], p[2] + s * t[2]);
        greatest = std::max(greatest, std::abs(height(q) - height(p)));
    }
    return greatest;
}

TEST(ReliefProperty, NoCliffAnywhere) {
    // A jump would show as a difference that does not shrink with the step.
    const std::vector<Vector> points = even_points(20000);
    const Height earth = earthlike(1, 1000);
    EXPECT_LT(greatest_step(earth, points, 10, 6.371e6), 60);
    EXPECT_LT(greatest_step(earth, points, 0.1, 6.371e6), 0.6);
    const Height moon = moonlike(1, 1000);
    EXPECT_LT(greatest_step(moon, points, 10, 1.7374e6), 60);
    EXPECT_LT(greatest_step(moon, points, 0.1, 1.7374e6), 0.6);
}

TEST(ReliefProperty, NoSeamAtTheAntimeridianPolesOrLatticePlanes) {
    std::vector<Vector> points;
    for (int i = -900; i < 900; ++i) points.push_back(at(0.1 * i, 180));
    for (int i = 0; i < 720; ++i) {
        points.push_back(at(89.9999, 0.5 * i));
        points.push_back(at(-89.9999, 0.5 * i));
        points.push_back(at(0, 0.5 * i));
    }
    for (const Height& height : {earthlike(1, 1000), moonlike(1, 1000)})
        EXPECT_LT(greatest_step(height, points, 0.1, 1.7374e6), 0.6);
    // From both sides of the antimeridian, one metre apart.
    const Height earth = earthlike(1, 1000);
    for (int i = -900; i < 900; ++i) {
        const double latitude = 0.1 * i;
        EXPECT_NEAR(earth(at(latitude, 179.999995)), earth(at(latitude, -179.999995)), 6) << latitude;
    }
}

TEST(ReliefProperty, NoPreferredDirectionOfTheAxes) {
    // Gradient noise on a bare lattice vanishes on its planes and shows them in the variance of differences
    // along the axes. Here the mean squared difference along x, y and z must agree within sampling error.
    const Height earth = earthlike(1, 5000);
    std::array<double, 3> energy{};
    for (const Vector& p : even_points(40000)) {
        const double h = earth(p);
        for (std::size_t k = 0; k < 3; ++k) {
            Vector q = p;
            q[k] += 2e-3;
            const double weight = 1 - p[k] * p[k];  // the share of the step that lies in the surface
            if (weight < 0.1) continue;
            const double d = earth(unit(q[0], q[1], q[2])) - h;
            energy[k] += d * d / weight;
        }
    }
    const auto [low, high] = std::minmax_element(energy.begin(), energy.end());
    EXPECT_LT(*high / *low, 1.35);
}

TEST(ReliefProperty, RefusesWavelengthsBelowOneMetre) {
    EXPECT_THROW(earthlike(1, 0.5), Error);
    EXPECT_THROW(moonlike(1, -1), Error);
    EXPECT_THROW(earthlike_height({1, 0, 0}, 1, std::nan("")), Error);
}

}  // namespace
}  // namespace carat::synth
