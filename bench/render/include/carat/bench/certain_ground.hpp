// Which pixels of a picture must show ground: their rays meet a place that lies below all that may be drawn
// there.
#pragma once

#include "carat/globe/ellipsoid.hpp"
#include "carat/render/view.hpp"

namespace carat::bench {

// A ray's own bound. Let S not lie deeper than m below the ellipsoid, and let every drawn patch P err by at
// most T pixels (Visibility::screen_error()). Move each point of S straight to its point of P. If a point X
// on screen at depth z along the view axis, theta off it, is passed by this, it lies on such a path: within
// delta of its begin on S, where f delta <= T z cos(theta), for X is in the patch's volume. So if X is deeper
// below the ellipsoid than
//
//   m + T z cos(theta) / f,
//
// it is passed by none and inside the drawn surface as it is inside S: the ray from an eye outside crosses
// the drawn surface before X. A first crossing through a patch that is not drawn there cannot be: such a
// patch is off the screen, or behind the horizon's ellipsoid, which the ray meets before, deeper than that
// bound.
//
// The body scaled by 1 - d/b lies deeper than d everywhere (visibility.cpp): X is deep enough if
// |X / axes| < 1 - d/b. Along the ray, with d linear in z, that is a quadratic inequality.
class CertainGround {
  public:
    // min_height: of S, metres. error: T, pixels; 0.01 is added for a device that snaps vertices to 1/256
    // pixel.
    CertainGround(const View& view, const Ellipsoid& body, double min_height, double error);

    // Whether the pixel's ray has such a point, exactly up to rounding.
    bool holds(int x, int y) const;

  private:
    View view_;
    Vec3 scale_;    // 1 / axes
    double limit_;  // 1 - m/b
    double error_;  // T / (f b)
};

}  // namespace carat::bench
