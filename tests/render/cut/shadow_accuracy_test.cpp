// Cast shadows against trigonometry.
#include <gtest/gtest.h>

#include <numbers>

#include "carat/render/octahedral.hpp"
#include "carat/render/shadows.hpp"
#include "render/cut/planets.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

constexpr double kRadians = std::numbers::pi / 180, kHeight = 1500, kWidth = 4000;

// A sphere with a ridge along the meridian of 0 degrees, slopes of 20.6 degrees on either side.
const FakeRepository& ridge() {
    static const FakeRepository repository([] {
        FakeOptions o;
        o.body = Ellipsoid(1.7e6, 1.7e6);
        o.log2_cells = 5;
        o.relief = [](const Vec3& n) {
            return std::max(0.0, kHeight * (1 - std::abs(std::atan2(n[1], n[0])) * 1.7e6 / kWidth));
        };
        o.depth = 2;
        o.deep = 16;
        o.deep_centre = {1, 0, 0};
        o.deep_radius = 0.009;
        return o;
    }());
    return repository;
}

View from_above(const Ellipsoid& body, double lat, double lon, double height) {
    ViewRequest r;
    r.eye = {lat, lon};
    r.height = height;
    r.width = 320;
    r.image_height = 240;
    r.fov = 50;
    return View(body, r);
}

double product(const Vec3& p, const Vec3& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; }

// Metres between the first two vertices.
double cell_of(const PatchMesh& mesh, double unit) {
    return norm(minus(to_metres(mesh.vertices[1].offset, unit), to_metres(mesh.vertices[0].offset, unit)));
}

// Where the sun stands due west at an elevation as seen from 0 N 0 E.
Vec3 western_sun(double elevation) { return {std::sin(elevation), -std::cos(elevation), 0}; }

TEST(Shadows, ARidgesShadowIsAsLongAsTrigonometrySays) {
    const FakeRepository& file = ridge();
    const double a = file.body().a();
    for (const double elevation : {8 * kRadians, 14 * kRadians}) {
        SCOPED_TRACE(elevation / kRadians);
        const View view = from_above(file.body(), 0.02, 0.15, 16e3);
        DrawList list = converged_cut(file, view, 1, 1.5);
        const ShadowCounters counters = cast_shadows(list, file, view, western_sun(elevation));
        EXPECT_GT(counters.views, 0);
        EXPECT_GT(counters.triangles, 0u);
        // The ray over the crest meets the sphere at the angle where (a + H) cos(el) = a cos(el - angle).
        const double tip = a * (elevation - std::acos((a + kHeight) * std::cos(elevation) / a));
        EXPECT_NEAR(tip, kHeight / std::tan(elevation), 0.04 * tip) << "nearly a plane";
        double dark = 0, bright = 1e9,
               spacing = 0;  // east of the crest: the last in shadow, the first in the light
        int checked = 0;
        for (const auto& mesh : list.meshes)
            for (std::size_t k = 0; k < mesh->vertices.size(); ++k) {
                UnitVector at;
                for (std::size_t c = 0; c < 3; ++c) at[c] = mesh->anchor[c] + mesh->vertices[k].offset[c];
                const Vec3 p = to_metres(at, view.unit());
                const double east = std::atan2(p[1], p[0]) * a, north = std::atan2(p[2], p[0]) * a;
                if (std::abs(north) > 5000 || std::abs(east) > 14000) continue;  // where the file is fine
                const int share = static_cast<int>(mesh->colours[k] >> 24);
                ++checked;
                if (east < -100) {
                    ASSERT_EQ(share, 255) << east << ' ' << north;
                } else if (east > 100) {
                    if (share == 0) dark = std::max(dark, east);
                    if (share == 255) bright = std::min(bright, east);
                }
                if (share != 255 && east > 100) spacing = std::max(spacing, cell_of(*mesh, view.unit()));
            }
        std::printf(
            "elevation %.0f: tip at %.0f m, last dark %.0f, first bright %.0f, %d vertices, cells of %.0f "
            "m\n",
            elevation / kRadians, tip, dark, bright, checked, spacing);
        EXPECT_GT(checked, 2000);
        // A cell, for that is how far vertices lie apart, and the error of the sun's cut along the ground.
        const double pixel = 16e3 / view.focal_pixels();
        const double slack = spacing + kShadowError * pixel / std::sin(elevation);
        EXPECT_NEAR(dark, tip, slack);
        EXPECT_NEAR(bright, tip, slack);
    }
}

// Day and night, and nothing in between: no spots on a smooth ball, from orbit and close by.
TEST(Shadows, SmoothGroundDoesNotShadeItself) {
    const FakeRepository& file = smooth_ball();
    const Vec3 sun = western_sun(0.5);
    for (const double height : {3e6, 1e5, 2e3}) {
        SCOPED_TRACE(height);
        const View view = from_above(file.body(), 0, height > 1e6 ? 20 : -10, height);
        DrawList list = converged_cut(file, view, 0.5, 1.5);
        cast_shadows(list, file, view, sun);
        int lit = 0, dark = 0;
        for (const auto& mesh : list.meshes)
            for (std::size_t k = 0; k < mesh->vertices.size(); ++k) {
                const double cosine = product(decode_octahedral(mesh->vertices[k].normal), sun);
                const int share = static_cast<int>(mesh->colours[k] >> 24);
                if (cosine > 0.01) {
                    ASSERT_EQ(share, 255) << cosine;
                } else if (cosine < 0) {
                    ASSERT_EQ(share, 0);
                }
                (share == 0 ? dark : lit)++;
            }
        EXPECT_GT(lit, 200);
        if (height > 1e6) {
            EXPECT_GT(dark, 200);
        }
    }
}

}  // namespace
}  // namespace carat::test
