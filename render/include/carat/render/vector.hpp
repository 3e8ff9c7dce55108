// Three-vectors of doubles, in the order of operations written here. Pure functions, for any finite values.
#pragma once

#include <cmath>

#include "carat/globe/sphere.hpp"

namespace carat {

inline Vec3 add(const Vec3& p, const Vec3& q) { return {p[0] + q[0], p[1] + q[1], p[2] + q[2]}; }
inline Vec3 subtract(const Vec3& p, const Vec3& q) { return {p[0] - q[0], p[1] - q[1], p[2] - q[2]}; }
inline Vec3 scale(double k, const Vec3& p) { return {k * p[0], k * p[1], k * p[2]}; }
inline double dot(const Vec3& p, const Vec3& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; }
inline double length(const Vec3& p) { return std::sqrt(dot(p, p)); }
inline Vec3 cross(const Vec3& p, const Vec3& q) {
    return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}

}  // namespace carat
