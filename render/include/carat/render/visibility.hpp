// Whether a half can be seen, and by how many pixels its flat patch can be wrong. Both are true bounds,
// derived in visibility.cpp: nothing visible is culled, and no drawn point is further from S on screen than
// screen_error().
#pragma once

#include <array>
#include <cstdint>

#include "carat/globe/bounds.hpp"
#include "carat/globe/diamond.hpp"
#include "carat/globe/ellipsoid.hpp"
#include "carat/render/view.hpp"

namespace carat {

// A convex set that contains every point of a half with height in a given range, and every flat triangle
// between such points: the hull of `points`, widened by `slack`. Metres.
struct HalfVolume {
    static constexpr int kCells = 4;  // the half's points are taken on a grid of 4 cells a side
    static constexpr int kPoints = 2 * (kCells + 1) * (kCells + 2) / 2;

    std::array<Vec3, kPoints> points{};
    Vec3 outwards{};  // a unit normal amid the half
    double slack = 0;
};
// What the volumes of a half have in common whatever its heights. Thread-safe.
class HalfShape {
  public:
    HalfShape(const Ellipsoid& body, const Half& half);
    // min_height <= max_height in metres; margin (metres) is added to the slack.
    HalfVolume volume(double min_height, double max_height, double margin) const;
    // curvature_bound() of the half; cells a power of two.
    CurvatureBound curvature(int cells) const;

  private:
    std::array<Vec3, HalfVolume::kPoints / 2> ground_{}, normals_{};  // metres, height 0; unit
    CurvatureBound curvature_;                                        // of HalfVolume::kCells
};
// HalfShape(body, half).volume(min_height, max_height, margin)
HalfVolume half_volume(const Ellipsoid& body, const Half& half, double min_height, double max_height,
                       double margin);

enum class Culled : std::uint8_t { none, frustum, horizon };

class Visibility {
  public:
    // No point of the surface S lies below min_height or above max_height (metres, the whole file). Drawn
    // patches may lie below S by as much as margin_pixels projects to; the horizon is lowered to allow for
    // it.
    Visibility(const View& view, const Ellipsoid& body, double min_height, double max_height,
               double margin_pixels);

    const View& view() const { return view_; }
    const Ellipsoid& body() const { return body_; }
    // `none` unless every point of the volume is off the screen or behind the horizon.
    Culled cull(const HalfVolume& volume) const;
    // Upper bound, pixels, of the distance on screen between X and Y for any X on screen and |X - Y| <= delta
    // metres, both in the volume. Infinite if the volume comes as near to the eye's plane as delta.
    double screen_error(const HalfVolume& volume, double delta) const;
    // Distance on screen, pixels, of samples `spacing` metres apart, face on, at the nearest point of the
    // volume. An estimate for what is drawn *on* the surface, not a bound.
    double screen_spacing(const HalfVolume& volume, double spacing) const;
    // Metres by which the horizon's ellipsoid lies below the body's at the poles; more elsewhere.
    double horizon_depth() const { return horizon_depth_; }

  private:
    bool outside_frustum(const HalfVolume& volume) const;
    bool below_horizon(const HalfVolume& volume) const;

    View view_;
    Ellipsoid body_;
    double corner_cosine_;
    double horizon_depth_ = 0;
    bool has_horizon_ = false;
    // Space scaled so that the lowered ellipsoid is the unit sphere; radius of a unit ball of metres there.
    Vec3 horizon_scale_{}, horizon_eye_{}, horizon_axis_{};
    double horizon_slack_ = 0, horizon_distance_ = 0, cone_sine_ = 0, cone_cosine_ = 0;
};

}  // namespace carat
