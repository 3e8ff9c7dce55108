// The gamma coder: a zero-quadtree whose leaves are Elias-gamma coded (C-BDAM 2006, section 5).
//
// The side x side matrix (side = 2^p) is cut into quadrants in the order (low i, low j), (low i, high j),
// (high i, low j), (high i, high j). A quadrant writes one bit, 1 if any of its values is not zero; the
// fourth quadrant of a parent whose first three are zero writes none, for it must be 1. A zero quadrant ends
// there. A quadrant of leaf_size writes its values in rows: zigzag z = 2v (v >= 0) or -2v - 1, then x = z + 1
// >= 1 as floor(log2 x) zero bits, a one bit and the low floor(log2 x) bits of x, lowest first. A matrix
// smaller than side x side (the residuals of interior vertices) is extended with absent values, which write
// nothing.
#pragma once

#include <cstdint>
#include <span>

#include "bits.hpp"

namespace carat {

// values: rows x rows, side/2 < rows <= side, side = 2^k >= leaf_size.
void gamma_encode(std::span<const std::int32_t> values, int rows, int side, int leaf_size, BitWriter& out);
// Bits gamma_encode would write.
std::uint64_t gamma_cost(std::span<const std::int32_t> values, int rows, int side, int leaf_size);
// Throws Error(corrupt) for codes no encoder writes; reads past the end are found by BitReader::finish.
void gamma_decode(BitReader& in, int rows, int side, int leaf_size, std::span<std::int32_t> values);

}  // namespace carat
