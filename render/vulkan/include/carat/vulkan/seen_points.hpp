// What is seen at the centre of a pixel, in double precision: where the ray through it meets the triangle
// that the device drew there.
//
// A vertex is three integers, and their difference to the eye is exact; so a point is off by a few roundings
// of its distance (2^-53 each), divided by the sine of the angle at which the ray meets the triangle. The
// device may draw a triangle whose edge passes the centre by its own rounding (1/256 of a pixel); then the
// point of the triangle nearest to the ray is taken, so that every point lies on the drawn surface.
#pragma once

#include <vector>

#include "carat/vulkan/renderer.hpp"

namespace carat {

struct SeenPoint {
    Vec3 position{};    // relative to the eye, body axes, metres; 0 in the background
    double height = 0;  // above the datum surface, metres: linear over the triangle
};

// One a pixel, row-major. frame: drawn from these meshes with `camera`, Aovs::patch asked for; unit: metres a
// length unit. Uses the threads of the current TBB arena.
std::vector<SeenPoint> seen_points(const Frame& frame, const Camera& camera, double unit, int cells,
                                   PatchList meshes);

}  // namespace carat
