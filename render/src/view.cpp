#include "carat/render/view.hpp"

#include <cmath>
#include <numbers>

#include "carat/globe/error.hpp"
#include "carat/render/vector.hpp"

namespace carat {
namespace {

void check(bool ok, const char* what) {
    if (!ok) throw Error(ErrorCode::usage, what);
}

void check(const Ellipsoid& body, const ViewRequest& r) {
    check(std::isfinite(r.height) && r.height > -body.min_curvature_radius() && r.height < 1e12,
          "eye height must be between the centre of the body and 1e12 m");
    check(std::isfinite(r.heading), "heading is not finite");
    check(r.pitch >= -90 && r.pitch <= 90, "pitch must be in [-90, 90] degrees");
    check(std::isfinite(r.roll), "roll is not finite");
    check(r.fov > 0 && r.fov < 180, "fov must be between 0 and 180 degrees");
    check(r.width >= 1 && r.width <= 65536 && r.image_height >= 1 && r.image_height <= 65536,
          "image size must be in [1, 65536] pixels");
}

}  // namespace

Camera make_camera(const Ellipsoid& body, const ViewRequest& r) {
    check(body, r);
    // Local frame. east depends on the longitude alone, so it is exact at the poles too.
    const Vec3 upwards = direction(r.eye);
    const Vec3 meridian = direction(Geodetic{0, r.eye.longitude});
    const Vec3 east{-meridian[1], meridian[0], 0};
    const Vec3 north = cross(upwards, east);
    // (cos p cos h, cos p sin h, sin p) by the same exact sines as latitude and longitude.
    const Vec3 heading = direction(Geodetic{0, r.heading}), pitch = direction(Geodetic{r.pitch, 0});
    const Vec3 ahead = add(scale(heading[0], north), scale(heading[1], east));
    Camera c;
    c.forward = add(scale(pitch[0], ahead), scale(pitch[2], upwards));
    const Vec3 up = add(scale(-pitch[2], ahead), scale(pitch[0], upwards)), right = cross(c.forward, up);
    const Vec3 roll = direction(Geodetic{0, r.roll});
    c.up = add(scale(roll[0], up), scale(roll[1], right));
    c.right = add(scale(roll[0], right), scale(-roll[1], up));
    c.eye = to_units(body.position(upwards, r.height), length_unit(body));
    c.vertical_fov = r.fov * std::numbers::pi / 180;
    c.width = r.width;
    c.height = r.image_height;
    return c;
}

View::View(const Camera& camera, double unit)
    : camera_(camera), unit_(unit), eye_(to_metres(camera.eye, unit)), focal_(camera.focal_pixels()) {
    tan_x_ = camera.width / (2 * focal_);
    tan_y_ = camera.height / (2 * focal_);
    corner_angle_ = std::atan(std::hypot(tan_x_, tan_y_));
    const auto plane = [&](const Vec3& axis, double tangent) {
        return scale(1 / std::hypot(1.0, tangent), add(axis, scale(tangent, camera.forward)));
    };
    sides_ = {plane(camera.right, tan_x_), plane(scale(-1, camera.right), tan_x_), plane(camera.up, tan_y_),
              plane(scale(-1, camera.up), tan_y_)};
}

View::View(const Ellipsoid& body, const ViewRequest& request)
    : View(make_camera(body, request), length_unit(body)) {}

Vec3 View::to_screen_axes(const Vec3& point) const {
    const Vec3 v = subtract(point, eye_);
    return {dot(camera_.right, v), dot(camera_.up, v), dot(camera_.forward, v)};
}

}  // namespace carat
