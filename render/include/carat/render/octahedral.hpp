// Unit vectors as two snorm16 on the octahedron |x| + |y| + |z| = 1, its lower half folded outwards
// (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors"). Error below
// 0.005 degrees.
#pragma once

#include <array>
#include <cstdint>

#include "carat/globe/sphere.hpp"

namespace carat {

// Any finite vector of non-zero length.
std::array<std::int16_t, 2> encode_octahedral(const Vec3& v);
// Unit length. -32768 reads as -32767.
Vec3 decode_octahedral(const std::array<std::int16_t, 2>& code);

}  // namespace carat
