// An Earth that never was: plates, continents, ranges, valleys, ocean floor. Heights in metres above the
// sphere of normals; radius_m only turns wavelengths into lattice sizes.
#pragma once

#include <cstdint>
#include <vector>

#include "curve.hpp"
#include "gullies.hpp"
#include "noise.hpp"
#include "pits.hpp"
#include "plates.hpp"

namespace carat::synth {

class EarthRelief {
  public:
    /// Octaves of wavelength below `min_wavelength_m` are left out. Making one costs some ten milliseconds.
    EarthRelief(std::uint64_t seed, double min_wavelength_m);
    /// Height in metres, n of unit length. Pure and thread-safe.
    double operator()(const Vec3& n) const noexcept;

  private:
    struct Crust {
        DualVec3 warped;
        PlateFields plates;
        Dual level;  ///< 0 at the coast, about +-1 far inland and far at sea, before relief is added
    };
    /// How the land is built; all in 0..1 and 0 at sea.
    struct Terrain {
        Dual inland;
        Dual mountains;
        Dual rough;
        Dual plateau;
    };
    struct Land {
        Dual height;
        double ruggedness;  ///< 0..1: how deep valleys are cut
        double grain;       ///< metres: fine roughness, which steers no valley
    };
    Crust crust(const Vec3& n) const noexcept;
    Terrain terrain(const Vec3& n, const Crust& c) const noexcept;
    Dual ranges(const Vec3& n, const Crust& c, const Terrain& t) const noexcept;
    Dual sea_floor(const Vec3& n, const Crust& c, const Dual& ocean) const noexcept;
    Land land(const Vec3& n, const Crust& c) const noexcept;
    double round_features(const Vec3& n, const Dual& level) const noexcept;
    void set_sea_level(std::uint64_t seed);

    Plates plates_;
    Warp drift_;  ///< bends plate borders and coasts
    Warp shear_;  ///< bends ridges within a range
    std::vector<Octave> continents_;
    std::vector<Octave> old_belts_;
    std::vector<Octave> provinces_;  ///< where land is rough, and where it is high and flat
    std::vector<Octave> ranges_;
    std::vector<Octave> hills_;
    std::vector<Octave> grain_;
    std::vector<Octave> abyssal_hills_;
    Gullies gullies_;
    PitClass craters_;
    PitClass seamounts_;
    Curve hypsometry_;
    double sea_ = 0;
};

}  // namespace carat::synth
