// Root values: the vertex heights of the six face diamonds, coded once for points shared by faces.
//
// Faces 0..5, rows i, columns j of the face diamond's index grid. A point on a lower-numbered face takes that
// face's value and writes nothing. Otherwise the index k = height / (2r + 1) is predicted from west w = k(i,
// j-1), north n = k(i-1, j) and north-west m = k(i-1, j-1): min(w, n) if m >= max(w, n), max(w, n) if m <=
// min(w, n), else w + n - m (row 0: w; column 0: n; the first: 0), and k - prediction modulo 2^32 is written
// as one Elias-gamma code of its zigzag plus one.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "carat/globe/lattice.hpp"

namespace carat {

using RootHeights = std::array<std::vector<std::int32_t>, kFaces>;

RootHeights decode_roots(std::span<const std::byte> bytes, int n, std::int32_t radius,
                         const std::string& file);

}  // namespace carat
