// A cratered sphere: highlands, flooded basins and craters of all sizes, on a body of the Moon's radius.
#pragma once

#include <cstdint>
#include <vector>

#include "noise.hpp"
#include "pits.hpp"

namespace carat::synth {

class MoonRelief {
  public:
    /// Octaves of wavelength, and craters of radius, below `min_wavelength_m` are left out.
    MoonRelief(std::uint64_t seed, double min_wavelength_m);
    /// Height in metres, n of unit length. Pure and thread-safe.
    double operator()(const Vec3& n) const noexcept;

  private:
    struct Size {
        PitClass pits;
        double weight;  ///< 0..1: fades out over the last factor of two
    };
    std::vector<Octave> highlands_;
    std::vector<Octave> grain_;
    PitClass basins_;
    std::vector<Size> craters_;
};

}  // namespace carat::synth
