// Dual: a value together with its gradient in the three coordinates of the unit sphere's space.
//
// The valleys are steered by the slope of the land they cut, so the formula carries its gradient along. Only
// + - * / and sqrt are used: the result is the same on every IEEE machine when contraction is off.
#pragma once

#include <algorithm>
#include <cmath>

#include "carat/globe/sphere.hpp"

namespace carat::synth {

constexpr double dot(const Vec3& a, const Vec3& b) noexcept {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
constexpr Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vec3& a) noexcept { return std::sqrt(dot(a, a)); }
inline Vec3 normalized(const Vec3& a) noexcept {
    const double l = length(a);
    return {a[0] / l, a[1] / l, a[2] / l};
}

struct Dual {
    double v = 0;
    double x = 0, y = 0, z = 0;

    constexpr Dual() = default;
    constexpr Dual(double value) noexcept : v(value) {}  // NOLINT: a constant is a Dual with no gradient
    constexpr Dual(double value, double gx, double gy, double gz) noexcept : v(value), x(gx), y(gy), z(gz) {}
    constexpr Vec3 gradient() const noexcept { return {x, y, z}; }
};

using DualVec3 = std::array<Dual, 3>;

constexpr Dual operator+(const Dual& a, const Dual& b) noexcept {
    return {a.v + b.v, a.x + b.x, a.y + b.y, a.z + b.z};
}
constexpr Dual operator-(const Dual& a, const Dual& b) noexcept {
    return {a.v - b.v, a.x - b.x, a.y - b.y, a.z - b.z};
}
constexpr Dual operator*(const Dual& a, const Dual& b) noexcept {
    return {a.v * b.v, a.x * b.v + a.v * b.x, a.y * b.v + a.v * b.y, a.z * b.v + a.v * b.z};
}
constexpr Dual operator*(double s, const Dual& a) noexcept { return {s * a.v, s * a.x, s * a.y, s * a.z}; }
constexpr Dual operator*(const Dual& a, double s) noexcept { return s * a; }
constexpr Dual& operator+=(Dual& a, const Dual& b) noexcept { return a = a + b; }

/// f(a) for a scalar function with value `f` and derivative `df` at a.
constexpr Dual chain(const Dual& a, double f, double df) noexcept {
    return {f, df * a.x, df * a.y, df * a.z};
}

inline Dual operator/(const Dual& a, const Dual& b) noexcept {
    const double r = 1 / b.v;
    return a * chain(b, r, -r * r);
}
inline Dual sqrt(const Dual& a) noexcept {
    const double r = std::sqrt(a.v);
    return chain(a, r, 0.5 / r);
}
/// |a| with the crease rounded over a width of about `e`.
inline Dual soft_abs(const Dual& a, double e) noexcept { return sqrt(a * a + e * e); }

/// 0 below `lo`, 1 above `hi`, cubic with level ends between; `lo` may be the larger one.
inline Dual smoothstep(double lo, double hi, const Dual& a) noexcept {
    const double t = std::clamp((a.v - lo) / (hi - lo), 0.0, 1.0);
    return chain(a, t * t * (3 - 2 * t), 6 * t * (1 - t) / (hi - lo));
}
/// 1 at a = 0, falling with level ends to 0 at |a| = width.
inline Dual hump(const Dual& a, double width) noexcept {
    const double t = a.v / width;
    const double k = 1 - t * t;
    return k <= 0 ? Dual(0) : chain(a, k * k, -4 * t * k / width);
}
/// Positive part with the corner rounded over a width of about `e`.
inline Dual soft_positive(const Dual& a, double e) noexcept { return 0.5 * (a + soft_abs(a, e)); }

}  // namespace carat::synth
