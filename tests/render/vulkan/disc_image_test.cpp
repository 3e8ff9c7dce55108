// The outline of an ellipsoid against rays cast on the CPU: every pixel well inside is drawn, every pixel
// well outside is not.
#include <cmath>

#include "planet.hpp"

namespace carat::test {

namespace {

constexpr std::array<float, 3> kMagenta{1, 0, 1};

struct Shot {
    const char* name;
    Geodetic above;
    double radii;  // distance of the eye from the centre, equatorial radii
    double fov, tilt, roll;
};

// Poles, a cube corner, a cube edge, the antimeridian; near and far, turned and rolled.
const Shot kShots[] = {
    {"equator", {0, 0}, 4, 40, 0, 0},      {"north pole", {90, 0}, 4, 40, 0, 30},
    {"south pole", {-90, 0}, 3, 60, 0, 0}, {"cube corner", {35.26438968, 45}, 3, 60, 5, 77},
    {"cube edge", {0, 45}, 5, 30, 0, -20}, {"antimeridian", {-12, 180}, 3.5, 50, -3, 0},
    {"near", {48, 11}, 1.25, 75, 20, 0},   {"nearer, at the limb", {-33, -71}, 1.05, 60, 65, 10},
    {"far", {20, 100}, 60, 2.5, 0, 45},
};

// How many of the rays at the corners of a square of two pixels around a pixel's centre hit the body grown by
// h.
int corner_hits(const Ellipsoid& body, double h, const Camera& camera, int x, int y) {
    int hits = 0;
    for (const double dx : {-0.5, 1.5}) {
        for (const double dy : {-0.5, 1.5}) {
            hits += hit(body, h, eye_metres(body, camera), ray(camera, x + dx, y + dy)).has_value();
        }
    }
    return hits;
}

class DiscImage : public RendererTest, public ::testing::WithParamInterface<Ellipsoid> {};

TEST_P(DiscImage, CoversExactlyTheRaysThatHit) {
    const Ellipsoid body = GetParam();
    constexpr int kCells = 32, kLevel = 4;
    const Patches patches = make_meshes(body, level_halves(kLevel), kCells, [](const Vec3&) { return 0.0; });
    Renderer& gpu = renderer(body, kCells);
    // Chords of 1/512 of a quarter circle: the flat triangles lie at most this far under the ellipsoid.
    const double sagitta = 2e-5 * body.a();
    for (const Shot& shot : kShots) {
        SCOPED_TRACE(shot.name);
        DrawRequest request;
        request.camera =
            look_down(body, shot.above, shot.radii * body.a(), 240, 180, shot.fov, shot.tilt, shot.roll);
        request.background = kMagenta;
        request.light.ambient = 1;
        const Frame frame = gpu.draw(request, patches);
        int inside = 0, outside = 0, border = 0;
        for (int y = 0; y < 180; ++y) {
            for (int x = 0; x < 240; ++x) {
                const float* pixel = frame.colour.at(x, y);
                const bool magenta = pixel[0] == 1 && pixel[1] == 0 && pixel[2] == 1;
                if (corner_hits(body, -sagitta, request.camera, x, y) == 4) {
                    ++inside;
                    ASSERT_FALSE(magenta) << "hole at " << x << ", " << y;
                    ASSERT_EQ(pixel[3], 1);
                } else if (corner_hits(body, 0, request.camera, x, y) == 0) {
                    ++outside;
                    ASSERT_TRUE(magenta) << "something at " << x << ", " << y;
                    ASSERT_EQ(pixel[3], 0);
                } else {
                    ++border;
                }
            }
        }
        EXPECT_GT(inside, 1000);
        EXPECT_GT(outside, 1000);
        EXPECT_LT(border, 2500);
    }
}

INSTANTIATE_TEST_SUITE_P(Bodies, DiscImage,
                         ::testing::Values(Ellipsoid::earth(), Ellipsoid(1000, 600, "pebble")),
                         [](const auto& body) { return body.param.name(); });

}  // namespace

}  // namespace carat::test
