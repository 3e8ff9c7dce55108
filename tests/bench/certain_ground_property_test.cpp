// The closed form of what a ray must meet, against small steps along the ray.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "carat/bench/certain_ground.hpp"
#include "carat/render/vector.hpp"

namespace carat::bench {
namespace {

// Greatest of 1 - (m + T z cos / f) / b - |X / axes| along the ray: positive where X is deep enough.
double deepest(const View& view, const Ellipsoid& body, double min_height, double error, int x, int y) {
    const Camera& c = view.camera();
    const double f = view.focal_pixels();
    const Vec3 ray = add(c.forward, add(scale((x + 0.5 - c.width / 2.0) / f, c.right),
                                        scale((c.height / 2.0 - y - 0.5) / f, c.up)));
    const double furthest = 2 * length(view.eye());
    double best = -1;
    const auto at = [&](double z) {
        const Vec3 p = add(view.eye(), scale(z, ray));
        const double lowered = std::max(0.0, -min_height) + (error + 0.01) * z / (length(ray) * f);
        return 1 - lowered / body.b() - length({p[0] / body.a(), p[1] / body.a(), p[2] / body.b()});
    };
    // A concave function of z: steps in proportion, then between the neighbours of the best.
    double z_best = 0;
    for (double z = furthest * 1e-8; z < furthest; z *= 1.02) {
        if (const double d = at(z); d > best) {
            best = d;
            z_best = z;
        }
    }
    for (double low = z_best / 1.02, high = z_best * 1.02, k = 0; k < 100; ++k) {
        const double a = low + (high - low) / 3, b = high - (high - low) / 3;
        (at(a) < at(b) ? low : high) = at(a) < at(b) ? a : b;
        best = std::max({best, at(a), at(b)});
    }
    return best;
}

TEST(CertainGround, IsWhatStepsAlongTheRayFind) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> share(0, 1);
    int certain = 0, not_certain = 0;
    for (const Ellipsoid& body : {Ellipsoid::earth(), Ellipsoid::moon(), Ellipsoid(1000, 900)})
        for (int k = 0; k < 40; ++k) {
            const double scale = body.a() / 6.4e6;
            ViewRequest request;
            request.eye = {180 * share(random) - 90, 360 * share(random) - 180};
            request.height = scale * std::pow(10, 1 + 7 * share(random));
            request.heading = 360 * share(random);
            request.pitch = -90 + 95 * share(random);
            request.fov = 20 + 60 * share(random);
            request.width = 40;
            request.image_height = 30;
            const View view(body, request);
            const double lowest = -2e4 * scale * share(random), error = 16 * share(random);
            const CertainGround ground(view, body, lowest, error);
            for (int y = 0; y < 30; y += 3)
                for (int x = 0; x < 40; x += 3) {
                    const double depth = deepest(view, body, lowest, error, x, y);
                    if (std::abs(depth) < 1e-9) continue;
                    EXPECT_EQ(ground.holds(x, y), depth > 0) << k << ": " << x << ", " << y << ", " << depth;
                    ++(depth > 0 ? certain : not_certain);
                }
        }
    EXPECT_GT(certain, 2000);
    EXPECT_GT(not_certain, 2000);
}

}  // namespace
}  // namespace carat::bench
