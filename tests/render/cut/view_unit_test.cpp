#include <gtest/gtest.h>

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "carat/globe/error.hpp"
#include "carat/render/view.hpp"

namespace carat {
namespace {

void expect_near(const Vec3& p, const Vec3& q, double tolerance) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(p[k], q[k], tolerance) << "component " << k;
}

TEST(LengthUnit, IsTheStatedPowerOfTwo) {
    EXPECT_EQ(length_unit(Ellipsoid::earth()), std::ldexp(1.0, -17));
    EXPECT_EQ(length_unit(Ellipsoid::moon()), std::ldexp(1.0, -19));
    EXPECT_EQ(length_unit(Ellipsoid::mars()), std::ldexp(1.0, -18));
    EXPECT_EQ(length_unit(Ellipsoid(1.5, 1.0)), std::ldexp(1.0, -39));
}

TEST(LengthUnit, RoundsToTheNearestHalvesAway) {
    EXPECT_EQ(to_units({1.25, -1.25, 1.5}, 0.5), (UnitVector{3, -3, 3}));
    EXPECT_EQ(to_units({0.24, -0.26, 0}, 0.5), (UnitVector{0, -1, 0}));
}

TEST(View, LocalFrameAgreesWithGeographicLib) {
    const Ellipsoid earth = Ellipsoid::earth();
    for (const double latitude : {-89.5, -33.0, 0.0, 47.25, 90.0, -90.0})
        for (const double longitude : {-180.0, -71.5, 0.0, 90.0, 133.0}) {
            const GeographicLib::LocalCartesian local(latitude, longitude, 1234.0,
                                                      GeographicLib::Geocentric::WGS84());
            const auto axis = [&](double east, double north, double up) {
                double la = 0, lo = 0, h = 0;
                local.Reverse(1e3 * east, 1e3 * north, 1e3 * up, la, lo, h);
                Vec3 p{}, o{};
                GeographicLib::Geocentric::WGS84().Forward(la, lo, h, p[0], p[1], p[2]);
                GeographicLib::Geocentric::WGS84().Forward(latitude, longitude, 1234.0, o[0], o[1], o[2]);
                return Vec3{(p[0] - o[0]) / 1e3, (p[1] - o[1]) / 1e3, (p[2] - o[2]) / 1e3};
            };
            ViewRequest r;
            r.eye = {latitude, longitude};
            r.height = 1234;
            r.heading = 90;
            r.pitch = 0;
            const Camera east = make_camera(earth, r);
            expect_near(east.forward, axis(1, 0, 0), 1e-9);
            expect_near(east.up, axis(0, 0, 1), 1e-9);
            expect_near(east.right, axis(0, -1, 0), 1e-9);
            r.heading = 0;
            r.pitch = 30;
            expect_near(make_camera(earth, r).forward, axis(0, std::sqrt(3) / 2, 0.5), 1e-9);
            r.pitch = -90;
            expect_near(make_camera(earth, r).forward, axis(0, 0, -1), 1e-9);
            expect_near(make_camera(earth, r).up, axis(0, 1, 0), 1e-9);
        }
}

// Clockwise: the camera's top leans to the right, so what is up in the world leans to the left of the
// picture.
TEST(View, RollTurnsTheCameraAboutItsAxis) {
    ViewRequest r;
    r.eye = {31, 52};
    r.heading = 40;
    r.pitch = -20;
    const Camera level = make_camera(Ellipsoid::earth(), r);
    r.roll = 90;
    const Camera rolled = make_camera(Ellipsoid::earth(), r);
    expect_near(rolled.forward, level.forward, 0);
    expect_near(rolled.up, level.right, 1e-15);
    r.roll = 30;
    const View view(Ellipsoid::earth(), r);
    Vec3 above = view.eye();
    for (std::size_t k = 0; k < 3; ++k) above[k] += 10 * level.forward[k] + level.up[k];
    expect_near(view.to_screen_axes(above), {-0.5, std::sqrt(3) / 2, 10}, 1e-8);
    r.roll = std::numeric_limits<double>::infinity();
    EXPECT_THROW(make_camera(Ellipsoid::earth(), r), Error);
}

TEST(View, LongitudeDecidesNorthAtThePoles) {
    ViewRequest r;
    r.eye = {90, 30};
    r.pitch = 0;
    expect_near(make_camera(Ellipsoid::moon(), r).forward, {-std::sqrt(3) / 2, -0.5, 0}, 1e-15);
    r.eye = {-90, 30};
    expect_near(make_camera(Ellipsoid::moon(), r).forward, {std::sqrt(3) / 2, 0.5, 0}, 1e-15);
}

TEST(View, EyeIsWhereItWasAsked) {
    ViewRequest r;
    r.eye = {-12.5, 171};
    r.height = 2.5e6;
    const Ellipsoid mars = Ellipsoid::mars();
    const View view(mars, r);
    expect_near(view.eye(), mars.position(direction(r.eye), r.height), view.unit());
}

TEST(View, FocalLengthAndFrustum) {
    ViewRequest r;
    r.fov = 90;
    r.width = 400;
    r.image_height = 200;
    const View view(Ellipsoid::earth(), r);
    EXPECT_NEAR(view.focal_pixels(), 100, 1e-9);
    EXPECT_NEAR(view.tan_y(), 1, 1e-12);
    EXPECT_NEAR(view.tan_x(), 2, 1e-12);
    EXPECT_NEAR(view.corner_angle(), std::atan(std::sqrt(5.0)), 1e-12);
    // A point on the left border lies on the left plane and inside the others.
    const Camera& c = view.camera();
    Vec3 v{};
    for (std::size_t k = 0; k < 3; ++k) v[k] = c.forward[k] - 2 * c.right[k];
    const auto side = [&](std::size_t plane) {
        const Vec3& n = view.side_planes()[plane];
        return n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
    };
    EXPECT_NEAR(side(0), 0, 1e-12);
    EXPECT_GT(side(1), 0);
    EXPECT_GT(side(2), 0);
    EXPECT_GT(side(3), 0);
}

TEST(View, RefusesWhatItCannotShow) {
    const auto refused = [](auto change) {
        ViewRequest r;
        change(r);
        EXPECT_THROW(make_camera(Ellipsoid::earth(), r), Error);
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    refused([](ViewRequest& r) { r.fov = 0; });
    refused([](ViewRequest& r) { r.fov = 180; });
    refused([](ViewRequest& r) { r.pitch = 91; });
    refused([](ViewRequest& r) { r.eye.latitude = -90.1; });
    refused([](ViewRequest& r) { r.width = 0; });
    refused([](ViewRequest& r) { r.image_height = -5; });
    refused([](ViewRequest& r) { r.height = -7e6; });
    refused([&](ViewRequest& r) { r.height = nan; });
    refused([&](ViewRequest& r) { r.heading = nan; });
    refused([&](ViewRequest& r) { r.fov = nan; });
    refused([&](ViewRequest& r) { r.pitch = nan; });
}

}  // namespace
}  // namespace carat
