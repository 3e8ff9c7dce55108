#include "carat/bench/surface_distance.hpp"

#include <algorithm>
#include <cmath>

#include "carat/globe/locate.hpp"
#include "carat/render/vector.hpp"

namespace carat::bench {

SurfaceDistance::SurfaceDistance(const std::shared_ptr<const Repository>& file)
    : surface_(file), body_(file->header().ellipsoid()) {}

SurfaceDistance::Place SurfaceDistance::place(const Vec3& normal) const {
    const Surface::Sample s = surface_.sample(lattice_position(normal));
    return {normal, s.height, s.spacing};
}

// Twice the Newton step towards the foot of the perpendicular: over a plane of slope s that lies d below the
// point, the foot is s d / (1 + s^2) away.
double SurfaceDistance::operator()(const Vec3& point) const {
    const Ellipsoid::NormalHeight at = body_.normal_height(point);
    const Vec3 axis = std::abs(at.normal[2]) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    Place here = place(at.normal);
    double nearest = std::abs(at.height - here.height);
    for (int k = 0; k < 2 && nearest > 0; ++k) {
        const Vec3 east = scale(1 / length(cross(axis, here.normal)), cross(axis, here.normal)),
                   north = cross(here.normal, east);
        const auto moved = [&](double e, double n) {
            const Vec3 there = add(here.normal, add(scale(e / body_.a(), east), scale(n / body_.a(), north)));
            return place(scale(1 / length(there), there));
        };
        const double step = std::max(nearest, 0.5 * here.spacing);
        const double x = (moved(step, 0).height - here.height) / step,
                     y = (moved(0, step).height - here.height) / step;
        const Vec3 off = subtract(point, body_.position(here.normal, here.height));
        const double above = dot(off, here.normal), east_off = dot(off, east), north_off = dot(off, north);
        // Solves for the foot on z = x e + y n, seen from (east_off, north_off, above).
        const double below = (above - x * east_off - y * north_off) / (1 + x * x + y * y);
        here = moved(east_off + x * below, north_off + y * below);
        nearest = std::min(nearest, length(subtract(point, body_.position(here.normal, here.height))));
    }
    return nearest;
}

double seen_as(const View& view, const Vec3& point, double metres) {
    const Vec3 v = view.to_screen_axes(point);
    return view.focal_pixels() * metres * length(v) / (v[2] * v[2]);
}

ErrorSpread error_spread(std::vector<double> errors) {
    if (errors.empty()) return {};
    std::sort(errors.begin(), errors.end());
    double squares = 0;
    for (const double e : errors) squares += e * e;
    const auto rank = static_cast<std::size_t>(std::ceil(0.999 * static_cast<double>(errors.size())));
    return {errors.back(), errors[std::max<std::size_t>(rank, 1) - 1],
            std::sqrt(squares / static_cast<double>(errors.size()))};
}

}  // namespace carat::bench
