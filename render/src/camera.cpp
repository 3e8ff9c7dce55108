#include <cmath>

#include "carat/render/patch_mesh.hpp"
#include "carat/render/vector.hpp"

namespace carat {

double length_unit(const Ellipsoid& body) { return std::ldexp(1.0, std::ilogb(body.a()) - 39); }

UnitVector to_units(const Vec3& position, double unit) {
    return {std::llround(position[0] / unit), std::llround(position[1] / unit),
            std::llround(position[2] / unit)};
}

Vec3 to_metres(const UnitVector& p, double unit) {
    return {static_cast<double>(p[0]) * unit, static_cast<double>(p[1]) * unit,
            static_cast<double>(p[2]) * unit};
}

double Camera::focal_pixels() const { return height / (2 * std::tan(vertical_fov / 2)); }

Vec3 Camera::ray(double x, double y) const {
    const double f = focal_pixels(), along_right = (x - 0.5 * width) / f, along_up = (0.5 * height - y) / f;
    return add(forward, add(scale(along_right, right), scale(along_up, up)));
}

}  // namespace carat
