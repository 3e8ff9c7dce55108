// AOVs against analytic rays and closed formulas.
#include <cmath>
#include <numbers>

#include "carat/globe/globe.hpp"
#include "planet.hpp"

namespace carat::test {

namespace {

constexpr double kRadians = std::numbers::pi / 180;

class AovAccuracy : public RendererTest {
  protected:
    const Ellipsoid body = Ellipsoid::earth();
    static constexpr int kCells = 64, kLevel = 4, kWidth = 320, kHeight = 240;

    static DrawRequest request(const Camera& camera) {
        DrawRequest r;
        r.camera = camera;
        r.aovs = {true, true, true, true, true};
        return r;
    }
};

Vec3 at(const Picture& p, int x, int y) { return {p.at(x, y)[0], p.at(x, y)[1], p.at(x, y)[2]}; }

TEST_F(AovAccuracy, PositionAndDepthLieOnTheEllipsoidAndOnTheirRay) {
    const Patches patches = make_meshes(body, level_halves(kLevel), kCells, [](const Vec3&) { return 0.0; });
    Renderer& gpu = renderer(body, kCells);
    // Cells of at most 45 km: the flat triangle lies up to (45 km)^2 / (8 a) * 2 below the ellipsoid.
    const double sagitta = 80;
    for (const double altitude : {3e7, 2e6, 3e5}) {
        SCOPED_TRACE(altitude);
        const Camera camera = look_down(body, {37, -120}, body.a() + altitude, kWidth, kHeight, 40, 10, 5);
        const Frame frame = gpu.draw(request(camera), patches);
        const Vec3 eye = eye_metres(body, camera);
        int seen = 0;
        for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
                if (frame.patch[static_cast<std::size_t>(y * kWidth + x)] == kNoPatch) continue;
                ++seen;
                const Vec3 p = at(frame.position, x, y);
                const double distance = std::sqrt(dot(p, p));
                const double height = body.normal_height(sum(eye, p)).height;
                // Interpolation in float at the pixel's centre; three roundings of the largest component.
                ASSERT_LE(height, 1e-6 * distance) << x << ", " << y;
                ASSERT_GE(height, -sagitta - 1e-6 * distance) << x << ", " << y;
                const auto pixel = project(camera, p);
                ASSERT_NEAR(pixel[0], x + 0.5, 0.01) << x << ", " << y;
                ASSERT_NEAR(pixel[1], y + 0.5, 0.01) << x << ", " << y;
                ASSERT_NEAR(frame.depth.at(x, y)[0], dot(camera.forward, p), 1e-6 * distance);
            }
        }
        EXPECT_GT(seen, kWidth * kHeight / 10);
    }
}

TEST_F(AovAccuracy, BackgroundIsZeroAndHasNoPatch) {
    const Patches patches = make_meshes(body, level_halves(2), kCells, [](const Vec3&) { return 0.0; });
    const Camera camera = look_down(body, {0, 0}, 10 * body.a(), kWidth, kHeight, 40);
    const Frame frame = renderer(body, kCells).draw(request(camera), patches);
    EXPECT_EQ(frame.patch[0], kNoPatch);
    EXPECT_EQ(frame.depth.at(0, 0)[0], 0);
    EXPECT_EQ(frame.height.at(0, 0)[0], 0);
    EXPECT_EQ(at(frame.position, 0, 0), (Vec3{0, 0, 0}));
    EXPECT_EQ(at(frame.normal, 0, 0), (Vec3{0, 0, 0}));
}

// A relief without symmetry: mirrored or turned pictures cannot agree.
double lopsided(const Vec3& n) {
    return 2000 * n[0] * n[1] + 900 * n[2] + 1500 * n[1] * n[2] * n[2] - 700 * n[0];
}

TEST_F(AovAccuracy, HeightsAndNormalsAreThoseOfThePlaceThatTheRayHits) {
    const Patches patches = make_meshes(body, level_halves(kLevel), kCells, lopsided);
    Renderer& gpu = renderer(body, kCells);
    for (const Geodetic above : {Geodetic{5, 40}, Geodetic{-50, -150}, Geodetic{85, 10}, Geodetic{0, 180}}) {
        const Camera camera = look_down(body, above, 3.5 * body.a(), kWidth, kHeight, 30);
        const Frame frame = gpu.draw(request(camera), patches);
        const Vec3 eye = eye_metres(body, camera);
        for (int y = 0; y < kHeight; y += 3) {
            for (int x = 0; x < kWidth; x += 3) {
                const Vec3 direction = ray(camera, x + 0.5, y + 0.5);
                const auto t = hit(body, 0, eye, direction);
                if (!t) continue;
                const auto place = body.normal_height(sum(eye, scaled(*t, direction)));
                if (dot(place.normal, unit(direction)) > -0.35)
                    continue;  // near the limb relief moves the hit
                // Relief moves the hit by up to 3 * |h| sideways, which changes the height by less than 10 m.
                ASSERT_NEAR(frame.height.at(x, y)[0], lopsided(place.normal), 10) << x << ", " << y;
                ASSERT_GT(dot(at(frame.normal, x, y), place.normal), std::cos(0.1 * kRadians))
                    << x << ", " << y;
            }
        }
    }
}

TEST_F(AovAccuracy, NorthIsUpAndEastIsRight) {
    const auto north_east = [](const Vec3& n) {
        const Geodetic g = geodetic(n);
        return g.latitude > 0 && g.latitude < 45 && g.longitude > 0 && g.longitude < 90 ? 1000.0 : -1000.0;
    };
    const Patches patches = make_meshes(body, level_halves(kLevel), kCells, north_east);
    const Camera camera = look_down(body, {0, 0}, 4 * body.a(), kWidth, kHeight, 30);
    const Frame frame = renderer(body, kCells).draw(request(camera), patches);
    const int right = kWidth / 2 + 30, left = kWidth / 2 - 30, up = kHeight / 2 - 30, down = kHeight / 2 + 30;
    EXPECT_FLOAT_EQ(frame.height.at(right, up)[0], 1000);
    EXPECT_FLOAT_EQ(frame.height.at(left, up)[0], -1000);
    EXPECT_FLOAT_EQ(frame.height.at(right, down)[0], -1000);
    EXPECT_FLOAT_EQ(frame.height.at(left, down)[0], -1000);
}

TEST_F(AovAccuracy, PatchNumbersNameTheHalfThatContainsThePlace) {
    const Patches patches = make_meshes(body, level_halves(kLevel), kCells, [](const Vec3&) { return 0.0; });
    const Camera camera = look_down(body, {30, 60}, 3 * body.a(), kWidth, kHeight, 30);
    const Frame frame = renderer(body, kCells).draw(request(camera), patches);
    int checked = 0;
    for (int y = 0; y < kHeight; y += 2) {
        for (int x = 0; x < kWidth; x += 2) {
            const std::uint64_t entry = frame.patch[static_cast<std::size_t>(y * kWidth + x)];
            if (entry == kNoPatch) continue;
            const Half half = half_of_pixel(entry);
            const Vec3 p = sum(eye_metres(body, camera), at(frame.position, x, y));
            const Location here = locate_in(lattice_position(body.normal_height(p).normal), half);
            const double slack = 1e-3;
            ASSERT_EQ(half.diamond.level(), kLevel);
            ASSERT_GE(here.s, -slack);
            ASSERT_LE(here.s, 1 + slack);
            ASSERT_GE(here.t, -slack);
            ASSERT_LE(here.t, 1 + slack);
            ASSERT_GE(half.side == 0 ? here.s - here.t : here.t - here.s, -slack);
            ++checked;
        }
    }
    EXPECT_GT(checked, 5000);
}

// With several samples a pixel AOVs come from a pass of their own; they must not change.
TEST_F(AovAccuracy, SamplesDoNotChangeAovs) {
    const Patches patches = make_meshes(body, level_halves(2), kCells, lopsided);
    Renderer& gpu = renderer(body, kCells);
    DrawRequest r = request(look_down(body, {30, 60}, 3 * body.a(), kWidth, kHeight, 50));
    const Frame one = gpu.draw(r, patches);
    r.samples = 4;
    const Frame four = gpu.draw(r, patches);
    ASSERT_EQ(four.counters.samples, 4) << "every Vulkan device draws four samples a pixel";
    EXPECT_EQ(one.position.values, four.position.values);
    EXPECT_EQ(one.normal.values, four.normal.values);
    EXPECT_EQ(one.patch, four.patch);
}

}  // namespace

}  // namespace carat::test
