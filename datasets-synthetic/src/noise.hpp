// Gradient noise in space and octaves of it. Position: unit-sphere coordinates; wavelength: metres on the
// body.
#pragma once

#include <cstdint>
#include <vector>

#include "dual.hpp"

namespace carat::synth {

/// Perlin's gradient noise with hashed gradients and quintic fade: about -1..1, standard deviation near 0.25,
/// and its exact gradient with respect to `q`. Twice continuously differentiable.
Dual gradient_noise(const Vec3& q, std::uint64_t seed) noexcept;

/// One octave: its own rotation, offset and lattice size, so that no two octaves share lattice planes.
struct Octave {
    std::array<Vec3, 3> rows;  ///< rotation times frequency
    Vec3 offset;
    std::uint64_t seed;
    double wavelength_m;
    double weight;  ///< 0..1: fades out over the last factor of two above the smallest wavelength
};

/// Octaves from `longest_m` downwards in steps of `lacunarity` while above both `shortest_m` and `limit_m`.
/// `limit_m` is the planet's smallest wavelength: an octave of wavelength L weighs clamp(L / limit_m - 1, 0,
/// 1).
struct Band {
    double longest_m;
    double shortest_m;
    double lacunarity;
};
std::vector<Octave> make_octaves(const Band& band, double limit_m, double radius_m, std::uint64_t seed);

/// `p` in the lattice of the octave.
Vec3 to_lattice(const Octave& octave, const Vec3& p) noexcept;

/// Noise of one octave at p; the gradient is with respect to p.
Dual octave_noise(const Octave& octave, const Vec3& p) noexcept;
/// The same at a displaced position; the gradient is with respect to what `p` differentiates by.
Dual octave_noise(const Octave& octave, const DualVec3& p) noexcept;

/// Sum of octaves, amplitude 1 for the first and `gain` times the last for each next one.
Dual fractal(const std::vector<Octave>& octaves, const Vec3& p, double gain) noexcept;
Dual fractal(const std::vector<Octave>& octaves, const DualVec3& p, double gain) noexcept;

/// p as an independent variable.
constexpr DualVec3 variable(const Vec3& p) noexcept {
    return {Dual(p[0], 1, 0, 0), Dual(p[1], 0, 1, 0), Dual(p[2], 0, 0, 1)};
}

/// A displacement field: p plus three independent fractals.
struct Warp {
    std::array<std::vector<Octave>, 3> axes;
    double amplitude;  ///< in radii
    double gain;
};
Warp make_warp(const Band& band, double amplitude_m, double gain, double limit_m, double radius_m,
               std::uint64_t seed);
DualVec3 displaced(const Warp& warp, const Vec3& p) noexcept;

}  // namespace carat::synth
