// Places worth a close look on an Earth-like planet.
#pragma once

#include <cstdint>

#include "carat/globe/ellipsoid.hpp"

namespace carat::synth {

struct Sites {
    Geodetic summit;  ///< among the highest land
    Geodetic coast;   ///< a rugged coast, as much land as sea within some kilometres
};

/// The best of some ten thousand hashed places between 60 S and 60 N, off the antimeridian.
Sites find_sites(std::uint64_t seed);

}  // namespace carat::synth
