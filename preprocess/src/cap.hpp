// Spherical caps of normals: a cheap test of what cannot meet.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "carat/globe/sphere.hpp"

namespace carat {

struct Cap {
    Vec3 axis{0, 0, 1};
    double radius = std::numbers::pi;  // angle in radians; pi: the whole sphere

    bool whole() const { return radius >= std::numbers::pi; }
};

inline double angle_between(const Vec3& a, const Vec3& b) {
    const double dx = a[0] - b[0], dy = a[1] - b[1], dz = a[2] - b[2];
    return 2 * std::asin(std::min(1.0, std::sqrt(dx * dx + dy * dy + dz * dz) / 2));
}

inline bool meet(const Cap& a, const Cap& b) {
    const double reach = a.radius + b.radius + 1e-9;
    return reach >= std::numbers::pi || angle_between(a.axis, b.axis) <= reach;
}

// A cap that contains the places and everything within `margin` radians of them.
inline Cap cap_of(std::span<const Vec3> places, double margin = 0) {
    Vec3 sum{0, 0, 0};
    for (const Vec3& n : places)
        for (std::size_t k = 0; k < 3; ++k) sum[k] += n[k];
    const double length = std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    if (!(length > 1e-6 * static_cast<double>(places.size()))) return {};
    Cap cap{{sum[0] / length, sum[1] / length, sum[2] / length}, 0};
    double chord2 = 0;
    for (const Vec3& n : places) {
        const double dx = n[0] - cap.axis[0], dy = n[1] - cap.axis[1], dz = n[2] - cap.axis[2];
        chord2 = std::max(chord2, dx * dx + dy * dy + dz * dz);
    }
    cap.radius = 2 * std::asin(std::min(1.0, std::sqrt(chord2) / 2)) + margin + 1e-12;
    return cap;
}

}  // namespace carat
