// Sample spacing, sagitta and bounding volumes of halves: all true bounds, derived in bounds.cpp.
#pragma once

#include "carat/globe/diamond.hpp"
#include "carat/globe/ellipsoid.hpp"

namespace carat {

// Mean sample spacing of a diamond's grid in metres: square root of its mean cell area. Relative error below
// 0.3 % for bodies with b >= a/2.
double sample_spacing(const Ellipsoid& body, DiamondId d, int cells);

// Bounds on how far a body's surface strays from the flat triangles of a half's grid.
struct CurvatureBound {
    // Upper bound, metres: distance at equal lattice coordinates between the ellipsoid and the linear
    // interpolation of its points over any one grid triangle of the half.
    double ellipsoid_sagitta = 0;
    // The same for the unit normal field (dimensionless): multiplies |height|.
    double normal_sagitta = 0;
    // Upper bound of |n(x) - n(y)| for x, y in one grid triangle: multiplies the height range in the
    // triangle.
    double normal_change = 0;

    // Bound of the distance between a flat triangle through three points of S and S itself (height linear in
    // lattice coordinates), |height| <= max_height and heights of one triangle differing by at most range;
    // metres. With weights w, linear interpolation L, h the height at the place: the point is off L by
    //   (e - L e) + h (n - L n) + L[(h - h_k) (n_k - L n)],
    // and the last term is a covariance under w: at most range/2 times the radius normal_change/2 of a ball
    // that holds the three normals.
    double of_heights(double max_height, double range) const {
        return ellipsoid_sagitta + normal_sagitta * max_height + 0.25 * normal_change * range;
    }
};
CurvatureBound curvature_bound(const Ellipsoid& body, const Half& half, int cells);

// A ball that contains ellipsoid point + h n for every place of the half and h in [min_height, max_height]
// metres.
struct BoundingBall {
    Vec3 centre{};
    double radius = 0;
};
BoundingBall bounding_ball(const Ellipsoid& body, const Half& half, double min_height, double max_height);

// A cone that contains every geodetic normal of the half: axis (unit) and cosine, sine of its half-angle.
struct NormalCone {
    Vec3 axis{};
    double cos_angle = 1, sin_angle = 0;
};
NormalCone normal_cone(const Half& half);

}  // namespace carat
