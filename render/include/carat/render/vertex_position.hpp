// Where a vertex is: one function of (lattice point, height), whichever patch asks. Vertices inside a patch,
// which no other has, may be another's rounding of it (patch_builder.hpp).
//
//   w = (t(X/2^30), t(Y/2^30), t(Z/2^30))           t(x) = tan(pi/4 x), exactly x at -1, 0, 1, and odd
//   e = (a^2 wx, a^2 wy, b^2 wz)                     a point of the ellipsoid is e / sqrt(e . w)
//   position = e / sqrt(e . w) + h w / |w|           1 / (both roots) by four of Newton's steps
//   vertex = round(position / u), halves to even
//
// t is Cephes' rational approximation (Moshier 1989), within 2 ulp. Against Ellipsoid::position() of
// direction(), which takes the C library's tangent, the position differs by at most kPositionRounding length
// units (measured in tests/render/cut). No fused multiply-add anywhere, and every operation is one that IEEE
// 754 rounds correctly: the same bits on every processor, scalar or vector, whatever its width.
#pragma once

#include "carat/globe/ellipsoid.hpp"
#include "carat/render/patch_mesh.hpp"

namespace carat {

// Length units, for |height| <= a; vertices inside patches included. Measured: 0.0005.
inline constexpr double kPositionRounding = 0.01;

// tan(pi/4 x), |x| <= 1.
double vertex_tangent(double x);

// height in metres above the ellipsoid; unit: length_unit(body).
UnitVector vertex_position(const Ellipsoid& body, const LatticePoint& p, double height, double unit);

}  // namespace carat
