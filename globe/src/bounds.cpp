#include "carat/globe/bounds.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "derivative.hpp"

namespace carat {
namespace {

constexpr double kAngle =
    std::numbers::pi / 4 / static_cast<double>(kLatticeExtent);  // radians a lattice unit

// Derivatives of the unit normal by face angle, greatest over the face (at its corners; tests/globe samples
// them).
constexpr double kNormalFirst = 1.1548;   // sqrt(4/3)
constexpr double kNormalSecond = 1.6330;  // sqrt(8/3)

Vec3 difference(const Vec3& p, const Vec3& q) { return {p[0] - q[0], p[1] - q[1], p[2] - q[2]}; }
double length(const Vec3& p) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]); }

// Length of a half's longest edge on the cube's face, radians of face angle. On a cube edge both ends still
// lie on the half's own face, so the lattice distance is the in-face distance.
double hypotenuse_angle(const Half& half) {
    return 2 * static_cast<double>(half_size(half.diamond.level())) * kAngle *
           (half.diamond.level() % 2 == 0 ? std::numbers::sqrt2 : 1.0);
}

int half_face(const DiamondCorners& c, int side) {
    const LatticeVector inside = wide(c.a) + wide(c.b) + wide(c.x[static_cast<std::size_t>(side)]);
    int face = 0;
    for (int f = 0; f < kFaces; ++f)
        if (inside[face_axis(f)] * face_sign(f) == 3 * kLatticeExtent) face = f;
    return face;
}

RealLattice centroid(const Half& half) {
    const DiamondCorners c = corners(half.diamond);
    const LatticeVector sum = wide(c.a) + wide(c.b) + wide(c.x[static_cast<std::size_t>(half.side)]);
    RealLattice r;
    r.face = half_face(c, half.side);
    for (int k = 0; k < 3; ++k) r.coordinates[static_cast<std::size_t>(k)] = static_cast<double>(sum[k]) / 3;
    r.coordinates[static_cast<std::size_t>(face_axis(r.face))] =
        static_cast<double>(face_sign(r.face) * kLatticeExtent);
    return r;
}

// Greatest second derivative anywhere in the half: a value at the centroid plus what the third derivative
// allows up to the farthest corner (sqrt(5)/3 of a leg, below 0.54 of the hypotenuse), or the bound for the
// whole body if that is smaller.
double second_derivative_bound(const Ellipsoid& body, const Half& half) {
    const double radius = 0.54 * hypotenuse_angle(half);
    const double slack = body.third_derivative_bound() * radius;
    const double smallest =
        body.min_curvature_radius() * 0.5;  // no place is flatter than this: skip a useless look
    if (smallest + slack >= body.second_derivative_bound()) return body.second_derivative_bound();
    return std::min(second_derivative_at(body, centroid(half)) + slack, body.second_derivative_bound());
}

// Positions of a coarse grid over the half, and by how much the half bulges out of their triangles.
constexpr int kBoundCells = 4;

template <class Visit>
void visit_grid(const Half& half, int cells, Visit visit) {
    const HalfFrame f = half_frame(half, cells);
    for (int r = 0; r <= cells; ++r)
        for (int c = 0; c <= r; ++c) visit(direction(half.side == 0 ? f.vertex(r, c) : f.vertex(c, r)));
}

// Linear interpolation over a triangle errs by at most M R^2 / 2, R the radius of its smallest enclosing
// circle (Waldron 1998): for a right triangle half the hypotenuse.
double interpolation_error(double second_derivative, double hypotenuse) {
    return second_derivative * hypotenuse * hypotenuse / 8;
}

double triangle_area(const Vec3& p, const Vec3& q, const Vec3& r) {
    const Vec3 u = difference(q, p), v = difference(r, p);
    return 0.5 * length({u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]});
}

double half_area(const Ellipsoid& body, const Half& half, int cells) {
    const HalfFrame f = half_frame(half, cells);
    const auto at = [&](int i, int j) { return body.position(direction(f.vertex(i, j)), 0); };
    double area = 0;
    for (int r = 0; r < cells; ++r)
        for (int c = 0; c <= r; ++c) {
            const int i = half.side == 0 ? r : c, j = half.side == 0 ? c : r;
            const Vec3 p = at(i, j), q = at(i + 1, j + 1);
            if (c < r || half.side == 0) area += triangle_area(p, at(i + 1, j), q);
            if (c < r || half.side == 1) area += triangle_area(p, q, at(i, j + 1));
        }
    return area;
}

}  // namespace

double sample_spacing(const Ellipsoid& body, DiamondId d, int cells) {
    const int level = d.level();
    const int steps = level < 4 ? 16 : level < 12 ? 4 : 1;  // flat triangles this small err by less than 1 %
    const double area = half_area(body, {d, 0}, steps) + half_area(body, {d, 1}, steps);
    return std::sqrt(area) / cells;
}

CurvatureBound curvature_bound(const Ellipsoid& body, const Half& half, int cells) {
    const double hypotenuse = hypotenuse_angle(half) / cells;
    return {interpolation_error(second_derivative_bound(body, half), hypotenuse),
            interpolation_error(kNormalSecond, hypotenuse), kNormalFirst * hypotenuse};
}

BoundingBall bounding_ball(const Ellipsoid& body, const Half& half, double min_height, double max_height) {
    const double middle = 0.5 * (min_height + max_height);
    BoundingBall ball;
    ball.centre = body.position(direction(centroid(half)), middle);
    visit_grid(half, kBoundCells, [&](const Vec3& n) {
        for (const double h : {min_height, max_height})
            ball.radius = std::max(ball.radius, length(difference(body.position(n, h), ball.centre)));
    });
    const double hypotenuse = hypotenuse_angle(half) / kBoundCells;
    const double highest = std::max(std::abs(min_height), std::abs(max_height));
    ball.radius += interpolation_error(second_derivative_bound(body, half), hypotenuse) +
                   interpolation_error(kNormalSecond, hypotenuse) * highest;
    // Rounding of the centre, the points and the sums, so that positions rounded to double are inside too.
    ball.radius += 1e-15 * (body.a() + highest) + 1e-9 * ball.radius;
    return ball;
}

NormalCone normal_cone(const Half& half) {
    NormalCone cone;
    cone.axis = direction(centroid(half));
    double chord = 0;
    visit_grid(half, kBoundCells,
               [&](const Vec3& n) { chord = std::max(chord, length(difference(n, cone.axis))); });
    chord += interpolation_error(kNormalSecond, hypotenuse_angle(half) / kBoundCells) + 1e-12;
    const double angle = 2 * std::asin(std::min(1.0, chord / 2));
    cone.cos_angle = std::cos(angle);
    cone.sin_angle = std::sin(angle);
    return cone;
}

}  // namespace carat
