#include "carat/bench/certain_ground.hpp"

#include <algorithm>
#include <cmath>

#include "carat/render/vector.hpp"

namespace carat::bench {

CertainGround::CertainGround(const View& view, const Ellipsoid& body, double min_height, double error)
    : view_(view),
      scale_{1 / body.a(), 1 / body.a(), 1 / body.b()},
      limit_(1 - std::max(0.0, -min_height) / body.b()),
      error_((error + 0.01) / (view.focal_pixels() * body.b())) {}

// |o + z d| < k - e z for some z > 0, with o, d eye and ray over the axes: (dd - ee) z^2 + 2 (od + ke) z +
// oo - kk < 0, on the side where k - e z > 0. The two sides are apart: between them, at z = k/e, it is not <
// 0.
bool CertainGround::holds(int x, int y) const {
    const Vec3 ray = view_.camera().ray(x + 0.5, y + 0.5);
    Vec3 o{}, d{};
    for (std::size_t k = 0; k < 3; ++k) {
        o[k] = scale_[k] * view_.eye()[k];
        d[k] = scale_[k] * ray[k];
    }
    const double e = error_ / length(ray);  // cos(theta) = 1 / |ray|
    const double second = dot(d, d) - e * e, first = dot(o, d) + limit_ * e,
                 zeroth = dot(o, o) - limit_ * limit_;
    if (!(limit_ > 0 && second > 0 && first < 0 && zeroth > 0)) return false;
    return first * first > second * zeroth && limit_ * second > e * -first;
}

}  // namespace carat::bench
