#include "carat/globe/sphere.hpp"

#include <cmath>
#include <numbers>

#include "carat/globe/error.hpp"

namespace carat {
namespace {

constexpr double kQuarterPi = std::numbers::pi / 4;
constexpr double kScale = 1.0 / static_cast<double>(kLatticeExtent);  // a power of two: exact

}  // namespace

double equiangular_tan(double x) {
    if (x == 1.0 || x == -1.0) return x;
    return std::tan(kQuarterPi * x);
}

double lattice_tangent(std::int32_t coordinate) { return equiangular_tan(coordinate * kScale); }

Vec3 direction_from_tangents(const Vec3& w) {
    const double length = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    return {w[0] / length, w[1] / length, w[2] / length};
}

Vec3 direction(const LatticePoint& p) {
    return direction_from_tangents({lattice_tangent(p.x), lattice_tangent(p.y), lattice_tangent(p.z)});
}

Vec3 direction(const RealLattice& r) {
    return direction_from_tangents({equiangular_tan(r.coordinates[0] * kScale),
                                    equiangular_tan(r.coordinates[1] * kScale),
                                    equiangular_tan(r.coordinates[2] * kScale)});
}

RealLattice lattice_position(const Vec3& n) {
    if (!std::isfinite(n[0]) || !std::isfinite(n[1]) || !std::isfinite(n[2]))
        throw Error(ErrorCode::usage, "direction is not finite");
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (std::abs(n[k]) > std::abs(n[axis])) axis = k;
    const double length = std::abs(n[axis]);
    if (length == 0) throw Error(ErrorCode::usage, "direction is the zero vector");
    RealLattice r;
    r.face = static_cast<int>(2 * axis) + (n[axis] < 0 ? 1 : 0);
    for (std::size_t k = 0; k < 3; ++k) {
        const double w = n[k] / length;
        const bool at_border = w == 1.0 || w == -1.0;
        r.coordinates[k] = (at_border ? w : std::atan(w) / kQuarterPi) * static_cast<double>(kLatticeExtent);
    }
    return r;
}

}  // namespace carat
