#include "derivative.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace carat {
namespace {

constexpr int kDirections = 12;  // over a half turn; derivatives are even or odd in the direction
constexpr double kStep = 1e-3;   // radians; central differences err by kStep^2 relative
constexpr double kMargin =
    1.02;  // between directions 15 degrees and places 2.8 degrees apart, and differencing

Vec3 difference(const Vec3& p, const Vec3& q) { return {p[0] - q[0], p[1] - q[1], p[2] - q[2]}; }
double length(const Vec3& p) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]); }

// Surface point at face angles (phi, psi) about the axis of a face; tan continues smoothly beyond the face's
// border.
Vec3 surface_point(const Ellipsoid& body, int face, double phi, double psi) {
    Vec3 w{};
    w[static_cast<std::size_t>(face_axis(face))] = face_sign(face);
    w[static_cast<std::size_t>(face_u_axis(face))] = std::tan(phi);
    w[static_cast<std::size_t>(face_v_axis(face))] = std::tan(psi);
    const double l = length(w);
    return body.position({w[0] / l, w[1] / l, w[2] / l}, 0);
}

DerivativeBounds derivatives_at(const Ellipsoid& body, int face, double phi, double psi, bool third) {
    DerivativeBounds d;
    const Vec3 centre = surface_point(body, face, phi, psi);
    for (int k = 0; k < kDirections; ++k) {
        const double angle = std::numbers::pi * k / kDirections;
        const double dx = kStep * std::cos(angle), dy = kStep * std::sin(angle);
        const auto at = [&](double t) { return surface_point(body, face, phi + t * dx, psi + t * dy); };
        const Vec3 plus = at(1), minus = at(-1);
        const Vec3 second = difference(difference(plus, centre), difference(centre, minus));
        d.second = std::max(d.second, length(second) / (kStep * kStep));
        if (!third) continue;
        const Vec3 wide = difference(at(2), at(-2)), narrow = difference(plus, minus);
        const Vec3 cubic = difference(difference(wide, narrow), narrow);
        d.third = std::max(d.third, length(cubic) / (2 * kStep * kStep * kStep));
    }
    return d;
}

}  // namespace

DerivativeBounds derivative_bounds(const Ellipsoid& body) {
    // Mirror images and quarter turns about the axis of rotation: a quarter of one equatorial and of one
    // polar face.
    constexpr int kSamples = 16;
    DerivativeBounds worst;
    for (const int face : {0, 4})
        for (int i = 0; i <= kSamples; ++i)
            for (int j = 0; j <= kSamples; ++j) {
                const double phi = std::numbers::pi / 4 * i / kSamples,
                             psi = std::numbers::pi / 4 * j / kSamples;
                const DerivativeBounds d = derivatives_at(body, face, phi, psi, true);
                worst.second = std::max(worst.second, d.second);
                worst.third = std::max(worst.third, d.third);
            }
    return {worst.second * kMargin, worst.third * kMargin};
}

double second_derivative_at(const Ellipsoid& body, const RealLattice& place) {
    const double to_angle = std::numbers::pi / 4 / static_cast<double>(kLatticeExtent);
    const double phi = place.coordinates[static_cast<std::size_t>(face_u_axis(place.face))] * to_angle;
    const double psi = place.coordinates[static_cast<std::size_t>(face_v_axis(place.face))] * to_angle;
    return kMargin * derivatives_at(body, place.face, phi, psi, false).second;
}

}  // namespace carat
