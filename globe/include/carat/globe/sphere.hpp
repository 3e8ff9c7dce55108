// Lattice point <-> geodetic normal (n-vector): w = tan(pi/4 * X/2^30) by component, n = w/|w|.
//
// Equi-angular: lines of constant lattice coordinate are great circles of n at equal angles. +-2^30 maps to
// +-1 exactly, so the map is continuous across cube edges and one function serves all faces. Error of n:
// below 4 ulp by component (tests/globe/sphere_accuracy_test.cpp).
#pragma once

#include <array>

#include "carat/globe/lattice.hpp"

namespace carat {

using Vec3 = std::array<double, 3>;

// tan(pi/4 * x) for x in [-1, 1], exact at -1, 0, 1, odd and increasing.
double equiangular_tan(double x);

// Unit geodetic normal at a lattice point.
Vec3 direction(const LatticePoint& p);

// The two steps of direction(), for grids whose coordinates repeat along rows: the tangent of one lattice
// coordinate, and the normal of three tangents. direction(p) is exactly their composition, bit for bit.
double lattice_tangent(std::int32_t coordinate);
Vec3 direction_from_tangents(const Vec3& w);

// A point on the cube's surface with real coordinates in lattice units; the face's own coordinate is +-2^30.
struct RealLattice {
    int face = 0;
    Vec3 coordinates{};
};
Vec3 direction(const RealLattice& r);

// Inverse of direction(): any non-zero vector. The face is that of the component of greatest magnitude, the
// lowest-numbered on ties. Throws Error(usage) for zero or non-finite vectors.
RealLattice lattice_position(const Vec3& n);

}  // namespace carat
