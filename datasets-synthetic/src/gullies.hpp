// Valleys: a cascade of ever smaller furrows that run down the slope of everything coarser than themselves.
//
// At each octave a stripe pattern is laid across the slope, cell by cell with hashed phases, so that stripes
// branch where cells meet; the furrows' own slope steers the next octave, so that small valleys join larger
// ones. The idea of slope-aligned stripe noise is that of C. John's and R. Skovbo Johansen's erosion filters,
// written here for the sphere with polynomial waves.
#pragma once

#include <vector>

#include "noise.hpp"

namespace carat::synth {

struct Gullies {
    std::vector<Octave> octaves;
    double radius_m;
    double
        slope;  ///< steepness (m/m) that one octave's furrows reach on a steep slope, at its best wavelength
    double longest_m;  ///< furrows much wider than this are shallower than `slope` asks
    double finest_m;   ///< and so are furrows much narrower than this
};

/// The height (m) that the furrows add at unit vector p on land of height gradient `slope` (m per radius),
/// `strength` times as deep as the full amplitude.
double gully_height(const Gullies& gullies, const Vec3& p, const Vec3& slope, double strength) noexcept;

}  // namespace carat::synth
