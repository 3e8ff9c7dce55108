// globe: the ellipsoid, the cube-sphere lattice, the diamond DAG and the connectivity of patches. Pure maths:
// no files, no threads, no state; every function is thread-safe.
//
//   frame       right-handed, body-fixed: +x at 0 N 0 E, +y at 0 N 90 E, +z at the north pole; metres
//   lattice     integer points on the surface of the cube [-2^30, 2^30]^3                       lattice.hpp
//   direction   w = tan(pi/4 * X/2^30) by component; n = w/|w| is the geodetic normal           sphere.hpp
//   position    (a^2 nx, a^2 ny, b^2 nz)/sqrt(a^2 nx^2 + a^2 ny^2 + b^2 nz^2) + h n             ellipsoid.hpp
//   diamond     two right triangles (halves) on a common longest edge; level l has 6 * 2^l      diamond.hpp
//   index grid  N x N vertices, N = 2^p + 1; (0,0), (N-1,N-1) are the ends of the longest edge
//   location    direction -> the diamond and fractional index that contains it, at any level    locate.hpp
//   patch       one half: N(N+1)/2 vertices and (N-1)^2 triangles, the 4-8 pattern              patch.hpp
//   bounds      sample spacing, sagitta and bounding volumes, all true upper bounds             bounds.hpp
//
// Exactness: everything about the lattice and the DAG is int64 arithmetic. position() is one function of
// (lattice point, height), never per face and compiled without contraction, so a vertex shared by patches is
// the same three doubles whichever patch asks.
#pragma once

#include "carat/globe/bounds.hpp"
#include "carat/globe/diamond.hpp"
#include "carat/globe/ellipsoid.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/lattice.hpp"
#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"
#include "carat/globe/sphere.hpp"
