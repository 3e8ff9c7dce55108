// Round features scattered over a sphere: craters and cones, at most one per lattice cell.
#pragma once

#include <cstdint>

#include "dual.hpp"

namespace carat::synth {

/// A feature at a point: distance from its centre in units of its radius (below kPitReach), radius in metres,
/// and a hash of its own for age, depth and kind.
struct Pit {
    double distance;
    double radius_m;
    std::uint64_t hash;
};
inline constexpr double kPitReach = 2.0;

/// Features of one size class: radii between `largest_m` / 2 and `largest_m`, a share `density` of the cells
/// filled.
struct PitClass {
    double largest_m;
    double density;
    double body_radius_m;
    std::uint64_t seed;
};

/// Calls f(Pit) for every feature of the class within kPitReach radii of the unit vector p.
template <typename F>
void for_each_pit(const PitClass& c, const Vec3& p, const F& f);

}  // namespace carat::synth

#include "pits_impl.hpp"
