// The design's maps in long double (64-bit mantissa), as references: lattice -> normal -> ellipsoid.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "carat/globe/ellipsoid.hpp"
#include "random.hpp"

namespace carat::test {

using Real = long double;
using Real3 = std::array<Real, 3>;

static_assert(std::numeric_limits<Real>::digits >= 64, "the references need more than double");

inline Real3 wide_real(const Vec3& v) { return {v[0], v[1], v[2]}; }
inline Real3 wide_real(const LatticePoint& p) {
    return {static_cast<Real>(p.x), static_cast<Real>(p.y), static_cast<Real>(p.z)};
}
inline Real3 operator+(const Real3& p, const Real3& q) { return {p[0] + q[0], p[1] + q[1], p[2] + q[2]}; }
inline Real3 operator-(const Real3& p, const Real3& q) { return {p[0] - q[0], p[1] - q[1], p[2] - q[2]}; }
inline Real3 operator*(Real k, const Real3& p) { return {k * p[0], k * p[1], k * p[2]}; }
inline Real dot(const Real3& p, const Real3& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; }
inline Real length(const Real3& p) { return std::sqrt(dot(p, p)); }

inline Real reference_tan(Real x) {
    if (x == 1 || x == -1) return x;
    return std::tan(std::numbers::pi_v<Real> / 4 * x);
}

// Lattice coordinates (units of the lattice) to the unit geodetic normal.
inline Real3 reference_direction(const Real3& coordinates) {
    const Real scale = 1 / static_cast<Real>(kLatticeExtent);
    const Real3 w{reference_tan(coordinates[0] * scale), reference_tan(coordinates[1] * scale),
                  reference_tan(coordinates[2] * scale)};
    return (1 / length(w)) * w;
}

inline Real3 reference_position(const Ellipsoid& body, const Real3& n, Real h) {
    const Real a2 = static_cast<Real>(body.a()) * body.a(), b2 = static_cast<Real>(body.b()) * body.b();
    const Real norm = std::sqrt(a2 * (n[0] * n[0] + n[1] * n[1]) + b2 * n[2] * n[2]);
    return {a2 * n[0] / norm + h * n[0], a2 * n[1] / norm + h * n[1], b2 * n[2] / norm + h * n[2]};
}

// |value - reference| in units in the last place of the double value (of the least normal number, if tiny).
inline Real ulps(double value, Real reference) {
    const double magnitude = std::max(std::abs(value), std::numeric_limits<double>::min());
    const Real ulp = std::nextafter(magnitude, std::numeric_limits<double>::infinity()) - magnitude;
    return std::abs(static_cast<Real>(value) - reference) / ulp;
}

inline Vec3 random_normal(Random& random) {
    for (;;) {
        const Vec3 v{random.real(-1, 1), random.real(-1, 1), random.real(-1, 1)};
        const double l = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        if (l > 0.01 && l < 1) return {v[0] / l, v[1] / l, v[2] / l};
    }
}

}  // namespace carat::test
