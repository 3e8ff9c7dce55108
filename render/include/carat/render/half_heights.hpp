// Heights of one half on their way through the cut: int64, in 2^-25 quanta.
//
// The fraction serves virtual refinement below the file's leaves, where V = P and C is the midpoint of the
// cell's diagonal. Over a leaf triangle heights are linear with whole gradients (quanta a cell), so after k
// virtual levels a height has at most ceil(k/2) fractional bits; k <= 50, so every midpoint is exact and S
// does not change at all. |height| <= 2^31 quanta: 56 bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "carat/codec/heights.hpp"
#include "carat/globe/bounds.hpp"
#include "carat/render/block_allocator.hpp"

namespace carat {

inline constexpr int kHeightFractionBits = 25;
inline constexpr double kHeightFraction = 1.0 / (1 << kHeightFractionBits);

// half_vertex_count(cells) values in the order of half_vertex_index: whole quanta where there has been no
// virtual refinement, else 2^-kHeightFractionBits quanta.
struct HalfHeights {
    std::vector<std::int32_t, BlockAllocator<std::int32_t>> whole;  // one of the two is empty
    std::vector<std::int64_t, BlockAllocator<std::int64_t>> fine;
    // Of each vertex, how rough procedural detail is there (detail.hpp); empty: there is none.
    std::vector<std::int32_t, BlockAllocator<std::int32_t>> rough = {};

    bool empty() const { return whole.empty() && fine.empty(); }
    std::size_t size() const { return whole.empty() ? fine.size() : whole.size(); }
    std::size_t bytes() const {
        return whole.size() * sizeof(whole[0]) + fine.size() * sizeof(fine[0]) +
               rough.size() * sizeof(rough[0]);
    }
    // In 2^-kHeightFractionBits quanta.
    std::int64_t at(std::size_t k) const {
        return whole.empty() ? fine[k] : std::int64_t{whole[k]} * (std::int64_t{1} << kHeightFractionBits);
    }
};

// The two halves of a face diamond.
std::array<HalfHeights, 2> split(const Heights& root);
// The int32 heights of a diamond from its two halves, into a matrix that is reused. Precondition: both are
// whole.
void whole_heights(const HalfHeights& half0, const HalfHeights& half1, int cells, Heights& out);

// The half of a child from the V and C of its refined parent.
HalfHeights gather_child(const RefinedHeights& parent, DiamondId parent_id, const Half& child_half);

// V and C of virtual refinement, and how rough detail is there; room may follow the last value.
struct VirtualHeights {
    int n = 0;
    std::vector<std::int64_t, BlockAllocator<std::int64_t>> v, c;  // n * n, (n - 1) * (n - 1)
    std::vector<std::int32_t, BlockAllocator<std::int32_t>> rough_v = {}, rough_c = {};
};
// V of virtual refinement, n * n values: P.
void virtual_vertices(const HalfHeights& half0, const HalfHeights& half1, int cells, std::int64_t* out);
// C is the midpoint of the cell's diagonal: exact without detail, else rounded down.
VirtualHeights refine_virtually(const HalfHeights& half0, const HalfHeights& half1, int cells);
HalfHeights gather_child(const VirtualHeights& parent, DiamondId parent_id, const Half& child_half);

// Least and greatest height of a half, and the greatest range within one triangle; metres.
struct HalfRange {
    double min = 0, max = 0, triangle_range = 0;
};
HalfRange half_range(const HalfHeights& heights, int cells, double quantum);

}  // namespace carat
