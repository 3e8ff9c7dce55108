// A sphere cut into plates that move: where crust is thick, where it collides, dives and tears.
//
// Plates are the cells of a weighted Voronoi diagram. With s_i = <p, site_i> + bias_i and m = max s_i, the
// distance a_i = m - s_i is 0 inside plate i and grows away from it; every field below is a smooth function
// of the a_i, hence continuous across plate borders and triple junctions.
#pragma once

#include <cstdint>
#include <vector>

#include "dual.hpp"

namespace carat::synth {

/// All fields except `crust` and `fold` lie in 0..1.
struct PlateFields {
    Dual crust;      ///< about -1 (oceanic) .. 1 (continental)
    Dual ridge;      ///< spreading: 1 at the axis, broad flanks
    Dual rift;       ///< narrow valley on the axis
    Dual trench;     ///< narrow, where one plate dives
    Dual belt;       ///< mountain belt on the overriding plate
    Dual collision;  ///< broad uplift where two continental plates meet
    Dual fold;       ///< not in 0..1: grows away from the nearest border, so that ranges can run along it
};

class Plates {
  public:
    explicit Plates(std::uint64_t seed);
    PlateFields at(const DualVec3& p) const noexcept;

  private:
    struct Plate {
        Vec3 site;
        double bias;
        double crust;
        Vec3 spin;
        std::uint64_t seed;
    };
    /// What never changes about two plates.
    struct Pair {
        Vec3 apart;   ///< from the over plate's site to the under one's, of unit length
        Vec3 strike;  ///< along the border, of unit length
        Vec3 spin;    ///< of the over plate, seen from the under one
        std::uint64_t seed;
        bool continental;  ///< both plates carry continents
    };
    struct Border;
    static void add_spreading(const Border& border, double opening, const DualVec3& p,
                              PlateFields& f) noexcept;
    static void add_convergence(const Border& border, double closing, PlateFields& f) noexcept;

    /// The pair of plates i and j, i over j.
    const Pair& pair(std::size_t over, std::size_t under) const noexcept {
        return pairs_[over * plates_.size() + under];
    }

    std::vector<Plate> plates_;
    std::vector<Pair> pairs_;
};

}  // namespace carat::synth
