// Height fields of the codec's tests: pure integer functions of the lattice point, in quanta, equal on every
// machine.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "carat/codec/heights.hpp"
#include "carat/globe/lattice.hpp"

namespace carat::test {

using Field = std::function<std::int32_t(const LatticePoint&)>;

// Uniform in [-amplitude, amplitude], independent from point to point.
Field white_noise(std::int32_t amplitude, std::uint64_t seed = 1);
// A smooth bowl and saddle.
Field smooth(std::int32_t amplitude);
// Octaves of value noise, the coarsest with a period of 2^coarsest_bits lattice units, each finer one half as
// high.
Field fractal(std::int32_t amplitude, int coarsest_bits = 29, int octaves = 16, std::uint64_t seed = 1);
// +amplitude on one side of a slanting plane, -amplitude on the other.
Field step(std::int32_t amplitude);
// +-amplitude by turns in cubes of 2^cube_bits lattice units.
Field checkerboard(std::int32_t amplitude, int cube_bits);
// -2^30, 0 and 2^30 at random.
Field extreme(std::uint64_t seed = 1);
Field constant(std::int32_t height);

struct NamedField {
    std::string name;
    Field field;
};
// One of each kind; heights within +-amplitude where the kind has an amplitude.
std::vector<NamedField> all_fields(std::int32_t amplitude, int cube_bits);

}  // namespace carat::test
