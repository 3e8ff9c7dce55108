// A camera over a body: what a user asks for, and the frustum in double precision.
//
//   frame    body-fixed, as in globe/globe.hpp; the eye in metres here, in length units in the Camera
//   heading  degrees clockwise from north; at a pole the longitude decides where north is (towards the
//            meridian of that longitude at the south pole, away from it at the north pole)
//   pitch    degrees up from the horizon, -90 looks straight down
//   roll     degrees clockwise that the camera is turned about its axis: the horizon's right end rises
//   screen   x = right . v, y = up . v, z = forward . v for v = point - eye; a point is on screen if z > 0,
//            |x| <= z tan_x and |y| <= z tan_y
#pragma once

#include <array>

#include "carat/globe/ellipsoid.hpp"
#include "carat/render/patch_mesh.hpp"

namespace carat {

// The options --eye, --heading, --pitch, --roll, --fov and --size.
struct ViewRequest {
    Geodetic eye;                          // degrees
    double height = 0;                     // metres above the ellipsoid
    double heading = 0;                    // degrees
    double pitch = -90;                    // degrees, [-90, 90]
    double roll = 0;                       // degrees
    double fov = 45;                       // degrees, vertical, (0, 180)
    int width = 1280, image_height = 720;  // pixels, [1, 65536]
};

// Throws Error(usage) for values outside the ranges above or an eye below the centre of curvature.
Camera make_camera(const Ellipsoid& body, const ViewRequest& request);

// A camera with everything the cut asks of it. Immutable; every member is thread-safe.
class View {
  public:
    // unit: metres a length unit of the camera.
    View(const Camera& camera, double unit);
    View(const Ellipsoid& body, const ViewRequest& request);

    const Camera& camera() const { return camera_; }
    double unit() const { return unit_; }                  // metres
    const Vec3& eye() const { return eye_; }               // metres
    double focal_pixels() const { return focal_; }         // f
    double tan_x() const { return tan_x_; }                // half width of the image plane at z = 1
    double tan_y() const { return tan_y_; }                // half height
    double corner_angle() const { return corner_angle_; }  // radians off axis of an image corner
    // Unit inward normals of the four side planes through the eye: left, right, bottom, top.
    const std::array<Vec3, 4>& side_planes() const { return sides_; }

    // x, y, z on screen axes of a point in metres.
    Vec3 to_screen_axes(const Vec3& point) const;

  private:
    Camera camera_;
    double unit_ = 0;
    Vec3 eye_{};
    double focal_ = 0, tan_x_ = 0, tan_y_ = 0, corner_angle_ = 0;
    std::array<Vec3, 4> sides_{};
};

}  // namespace carat
