#include "derivative.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace carat {
namespace {

constexpr int kDirections = 12;  // of third derivatives, over a half turn
constexpr int kFineDirections =
    48;                         // of second derivatives: 3.75 degrees apart, at most 0.1 % below the greatest
constexpr double kStep = 1e-3;  // radians; central differences err by kStep^2 relative
constexpr double kMargin = 1.02;  // between places 2.8 degrees apart and directions, and differencing

Vec3 difference(const Vec3& p, const Vec3& q) { return {p[0] - q[0], p[1] - q[1], p[2] - q[2]}; }
double length(const Vec3& p) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]); }

// Surface point at a place of a face, given by the tangents of its angles.
Vec3 surface_point_at(const Ellipsoid& body, int face, double u, double v) {
    Vec3 w{};
    w[static_cast<std::size_t>(face_axis(face))] = face_sign(face);
    w[static_cast<std::size_t>(face_u_axis(face))] = u;
    w[static_cast<std::size_t>(face_v_axis(face))] = v;
    const double l = length(w);
    return body.position({w[0] / l, w[1] / l, w[2] / l}, 0);
}

// Surface point at face angles (phi, psi) about the axis of a face; tan continues smoothly beyond the face's
// border.
Vec3 surface_point(const Ellipsoid& body, int face, double phi, double psi) {
    return surface_point_at(body, face, std::tan(phi), std::tan(psi));
}

// Weights of the three second derivatives in the one along a direction: cos^2, 2 cos sin, sin^2.
struct DirectionWeights {
    std::array<double, kFineDirections> uu{}, uv{}, vv{};

    DirectionWeights() {
        for (std::size_t k = 0; k < kFineDirections; ++k) {
            const double angle = std::numbers::pi * static_cast<double>(k) / kFineDirections;
            const double c = std::cos(angle), s = std::sin(angle);
            uu[k] = c * c;
            uv[k] = 2 * c * s;
            vv[k] = s * s;
        }
    }
};

// Greatest length of the second derivative over directions.
double greatest_second(const Vec3& uu, const Vec3& uv, const Vec3& vv) {
    static const DirectionWeights weights;
    std::array<double, kFineDirections> squared{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < kFineDirections; ++k) {
            const double along = uu[i] * weights.uu[k] + uv[i] * weights.uv[k] + vv[i] * weights.vv[k];
            squared[k] += along * along;
        }
    return std::sqrt(*std::max_element(squared.begin(), squared.end()));
}

double second_derivative(const Ellipsoid& body, int face, double phi, double psi) {
    std::array<double, 3> u{}, v{};
    for (std::size_t k = 0; k < 3; ++k) {
        u[k] = std::tan(phi + (static_cast<double>(k) - 1) * kStep);
        v[k] = std::tan(psi + (static_cast<double>(k) - 1) * kStep);
    }
    const auto at = [&](int i, int j) {
        return surface_point_at(body, face, u[static_cast<std::size_t>(i + 1)],
                                v[static_cast<std::size_t>(j + 1)]);
    };
    const Vec3 centre = at(0, 0);
    const auto bend = [&](const Vec3& plus, const Vec3& minus) {
        return difference(difference(plus, centre), difference(centre, minus));
    };
    Vec3 uv = difference(difference(at(1, 1), at(1, -1)), difference(at(-1, 1), at(-1, -1)));
    for (double& x : uv) x /= 4;
    return greatest_second(bend(at(1, 0), at(-1, 0)), uv, bend(at(0, 1), at(0, -1))) / (kStep * kStep);
}

double third_derivative(const Ellipsoid& body, int face, double phi, double psi) {
    double greatest = 0;
    for (int k = 0; k < kDirections; ++k) {
        const double angle = std::numbers::pi * k / kDirections;
        const double dx = kStep * std::cos(angle), dy = kStep * std::sin(angle);
        const auto at = [&](double t) { return surface_point(body, face, phi + t * dx, psi + t * dy); };
        const Vec3 wide = difference(at(2), at(-2)), narrow = difference(at(1), at(-1));
        greatest = std::max(greatest, length(difference(difference(wide, narrow), narrow)));
    }
    return greatest / (2 * kStep * kStep * kStep);
}

DerivativeBounds sampled_bounds(const Ellipsoid& body) {
    // Mirror images and quarter turns about the axis of rotation: a quarter of one equatorial and of one
    // polar face.
    constexpr int kSamples = 16;
    DerivativeBounds worst;
    for (const int face : {0, 4})
        for (int i = 0; i <= kSamples; ++i)
            for (int j = 0; j <= kSamples; ++j) {
                const double phi = std::numbers::pi / 4 * i / kSamples,
                             psi = std::numbers::pi / 4 * j / kSamples;
                worst.second = std::max(worst.second, second_derivative(body, face, phi, psi));
                worst.third = std::max(worst.third, third_derivative(body, face, phi, psi));
            }
    return {worst.second * kMargin, worst.third * kMargin};
}

}  // namespace

DerivativeBounds derivative_bounds(const Ellipsoid& body) {
    // Milliseconds of work, and a program opens many files of one body.
    thread_local struct {
        double a = 0, b = 0;
        DerivativeBounds bounds;
    } last;
    if (last.a != body.a() || last.b != body.b()) last = {body.a(), body.b(), sampled_bounds(body)};
    return last.bounds;
}

double second_derivative_at(const Ellipsoid& body, const RealLattice& place) {
    const double to_angle = std::numbers::pi / 4 / static_cast<double>(kLatticeExtent);
    const double phi = place.coordinates[static_cast<std::size_t>(face_u_axis(place.face))] * to_angle;
    const double psi = place.coordinates[static_cast<std::size_t>(face_v_axis(place.face))] * to_angle;
    return kMargin * second_derivative(body, place.face, phi, psi);
}

}  // namespace carat
