// Directional derivatives of the ellipsoid's surface over a cube face, for the sagitta bounds.
#pragma once

#include "carat/globe/ellipsoid.hpp"

namespace carat {

struct DerivativeBounds {
    double second = 0, third = 0;  // metres per radian^2, per radian^3
};
// Greatest values over the whole body, found by dense sampling, with a margin of 2 %.
DerivativeBounds derivative_bounds(const Ellipsoid& body);

// Greatest second derivative over directions at one place, metres per radian^2 (not a bound nearby).
double second_derivative_at(const Ellipsoid& body, const RealLattice& place);

}  // namespace carat
