#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "carat/render/octahedral.hpp"

namespace carat {
namespace {

double degrees_between(const Vec3& p, const Vec3& q) {
    const Vec3 c{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
    return std::atan2(std::hypot(c[0], c[1], c[2]), p[0] * q[0] + p[1] * q[1] + p[2] * q[2]) *
           57.29577951308232;
}

TEST(Octahedral, AxesAreExact) {
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            Vec3 v{};
            v[static_cast<std::size_t>(axis)] = sign;
            EXPECT_EQ(decode_octahedral(encode_octahedral(v)), v);
        }
}

TEST(Octahedral, ErrorIsBelowTheStatedBound) {
    std::mt19937_64 generator(7);
    std::normal_distribution<double> normal;
    double worst = 0;
    for (int k = 0; k < 200000; ++k) {
        Vec3 v{normal(generator), normal(generator), normal(generator)};
        if (k % 3 == 0) v[2] *= 1e-6;  // the fold
        const double length = std::hypot(v[0], v[1], v[2]);
        worst = std::max(worst, degrees_between({v[0] / length, v[1] / length, v[2] / length},
                                                decode_octahedral(encode_octahedral(v))));
    }
    EXPECT_LT(worst, 0.005);
    EXPECT_GT(worst, 0.0005);
}

}  // namespace
}  // namespace carat
