// From a place to the diamond, half and fractional index that contain it.
#pragma once

#include "carat/globe/diamond.hpp"
#include "carat/globe/sphere.hpp"

namespace carat {

// A place inside a half: index coordinates in units of the whole grid, 0 <= s, t <= 1 (i = s * cells, j = t *
// cells), s >= t for side 0 and s <= t for side 1, up to rounding (clamped to that range).
struct Location {
    Half half;
    double s = 0, t = 0;
};

// The half of the given level (0 to 50) that contains the place. On a common edge, the choice is
// deterministic.
Location locate(const RealLattice& place, int level);
// Index coordinates of a place within a given half; not clamped, meaningful only on the half's own face.
Location locate_in(const RealLattice& place, const Half& half);

}  // namespace carat
