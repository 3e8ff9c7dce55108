// Heights of one half on their way through the cut: int64, in 2^-25 quanta.
//
// The fraction serves virtual refinement below the file's leaves, where V = P and C is the midpoint of the
// cell's diagonal. Over a leaf triangle heights are linear with whole gradients (quanta a cell), so after k
// virtual levels a height has at most ceil(k/2) fractional bits; k <= 50, so every midpoint is exact and S
// does not change at all. |height| <= 2^31 quanta: 56 bits.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "carat/codec/heights.hpp"
#include "carat/globe/bounds.hpp"

namespace carat {

inline constexpr int kHeightFractionBits = 25;
inline constexpr double kHeightFraction = 1.0 / (1 << kHeightFractionBits);

// half_vertex_count(cells) values in the order of half_vertex_index.
using HalfHeights = std::vector<std::int64_t>;

// The two halves of a face diamond.
std::array<HalfHeights, 2> split(const Heights& root);
// The int32 heights of a diamond from its two halves. Precondition: no fractions (no virtual ancestor).
Heights whole_heights(const HalfHeights& half0, const HalfHeights& half1, int cells);

// The half of a child from the V and C of its refined parent.
HalfHeights gather_child(const RefinedHeights& parent, DiamondId parent_id, const Half& child_half);

// V and C of virtual refinement.
struct VirtualHeights {
    int n = 0;
    std::vector<std::int64_t> v, c;  // n * n, (n - 1) * (n - 1)
};
VirtualHeights refine_virtually(const HalfHeights& half0, const HalfHeights& half1, int cells);
HalfHeights gather_child(const VirtualHeights& parent, DiamondId parent_id, const Half& child_half);

// Least and greatest height of a half, and the greatest range within one triangle; metres.
struct HalfRange {
    double min = 0, max = 0, triangle_range = 0;
};
HalfRange half_range(const HalfHeights& heights, int cells, double quantum);

}  // namespace carat
