// A path of keyframes: where the eye is at any time. A pure function of time; no files, no GPU.
//
//   place     along the geodesic (GeographicLib) between neighbouring keyframes
//   height    above the keyframe's base exponential in time, so that a descent from orbit takes as long for
//             each factor of height; the base linear
//   speed     over ground in proportion to height above the base: the fraction of the way flown is (r^u - 1)/
//             (r - 1), r the ratio of the heights and u the fraction of the time, in the limit u for r = 1
//   angles    heading and roll by the shorter way, pitch and fov: monotone cubics (Fritsch and Butland
//             1984), so turns have no jerks at keyframes and never swing beyond them; linear between two
//   ends      from rest and to rest, over at most four tenths of the path, four seconds and one segment each
//   times     the eye is at each keyframe at its time
#pragma once

#include <cstddef>
#include <vector>

#include "carat/render/view.hpp"

namespace carat {

struct Keyframe {
    double time = 0;                            // seconds
    Geodetic eye;                               // degrees
    double height = 0;                          // metres above the ellipsoid, > base
    double base = 0;                            // metres above the ellipsoid: the ground near the ground
    double heading = 0, pitch = -90, fov = 45;  // degrees
    double roll = 0;                            // degrees
};

class Flight {
  public:
    // At least two keyframes with ascending times. Throws Error(usage) otherwise, or for places that are
    // none.
    Flight(const Ellipsoid& body, std::vector<Keyframe> keyframes);

    double duration() const;  // seconds
    // The view at `time` seconds after the first keyframe, clamped to the path; picture sizes are left to the
    // caller.
    ViewRequest at(double time) const;

  private:
    struct Segment {
        double distance = 0;  // metres
        double azimuth = 0;   // degrees, at the segment's begin
    };
    // An angle over the keyframes: values and rates there.
    struct Turn {
        std::vector<double> value, rate;  // degrees, degrees a second
    };
    Turn turn(double Keyframe::*angle, bool by_shorter_way) const;
    double at(const Turn& turn, std::size_t segment, double u) const;
    double eased(double time) const;

    double a_, f_;  // of the body
    std::vector<Keyframe> keys_;
    std::vector<Segment> segments_;
    Turn heading_, pitch_, fov_, roll_;
};

}  // namespace carat
