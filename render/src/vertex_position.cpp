#include "carat/render/vertex_position.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "whole_units.hpp"

namespace carat {
namespace {

double root(double x) { return std::sqrt(x); }
double constant(double x, double) { return x; }
double inverse_root_guess(double x) {
    return std::bit_cast<double>(0x5FE6EB50C7B537A9 - (std::bit_cast<std::uint64_t>(x) >> 1));
}

#define VERTEX_FORMULA
#include "vertex_formula.inc"
#undef VERTEX_FORMULA

}  // namespace

double vertex_tangent(double x) { return x == 1.0 || x == -1.0 ? x : tangent(x); }

UnitVector vertex_position(const Ellipsoid& body, const LatticePoint& p, double height, double unit) {
    constexpr double kScale = 1.0 / static_cast<double>(kLatticeExtent);
    const Body<double> b{body.a() * body.a(), body.b() * body.b(), 1 / unit};
    const std::array<double, 3> x = position(b, vertex_tangent(p.x * kScale), vertex_tangent(p.y * kScale),
                                             vertex_tangent(p.z * kScale), height);
    return {nearest_whole(x[0]), nearest_whole(x[1]), nearest_whole(x[2])};
}

}  // namespace carat
