#include "carat/globe/sphere.hpp"

#include <cmath>
#include <numbers>

#include "carat/globe/error.hpp"

namespace carat {
namespace {

constexpr double kQuarterPi = std::numbers::pi / 4;
constexpr double kScale = 1.0 / static_cast<double>(kLatticeExtent);  // a power of two: exact

Vec3 normalised(double x, double y, double z) {
    const double length = std::sqrt(x * x + y * y + z * z);
    return {x / length, y / length, z / length};
}

}  // namespace

double equiangular_tan(double x) {
    if (x == 1.0 || x == -1.0) return x;
    return std::tan(kQuarterPi * x);
}

Vec3 direction(const LatticePoint& p) {
    return normalised(equiangular_tan(p.x * kScale), equiangular_tan(p.y * kScale),
                      equiangular_tan(p.z * kScale));
}

Vec3 direction(const RealLattice& r) {
    return normalised(equiangular_tan(r.coordinates[0] * kScale), equiangular_tan(r.coordinates[1] * kScale),
                      equiangular_tan(r.coordinates[2] * kScale));
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
