// Summaries of halves: min, max and delta, and how delta is computed over reconstructed heights.
#pragma once

#include <cstdint>
#include <functional>

#include "carat/codec/heights.hpp"
#include "carat/globe/bounds.hpp"

namespace carat {

// Summary of a half, exact or rounded outwards for the file: heights in quanta, delta in metres.
struct SummaryValues {
    std::int32_t min = 0, max = 0;
    double delta = 0;
    bool operator==(const SummaryValues&) const = default;
};

// The grid that a file's summaries are rounded outwards to, the same for every page: a summary that is
// rounded before it goes into that of the half above makes both a matter of what the file itself says.
class SummaryGrid {
  public:
    // a: equatorial semi-axis, metres.
    SummaryGrid(double a, double quantum, int log2_cells);

    // Heights of a level's summaries are multiples of this, quanta; a power of two, that of the level above
    // is no smaller.
    std::int64_t unit(int level) const;
    // Heights to multiples of the unit, delta to a sixteenth of an octave; rounded twice is rounded once.
    SummaryValues rounded(const SummaryValues& s, int level) const;

  private:
    static constexpr int kGreatestUnit = 24;  // log2
    int exponent_, log2_cells_;
};

// Least and greatest height of a half's own vertices, and the greatest range within one cell, quanta.
struct HeightRange {
    std::int32_t min = 0, max = 0;
    std::int64_t cell_range = 0;
};
HeightRange height_range(const std::int32_t* p, int n, int side);

// Greatest |coarse surface - fine vertex| over the vertices of `fine`, a descendant of `coarse` at most 6
// levels deeper, both linear over their 4-8 triangles in lattice coordinates. Since every coarse triangle is
// a union of fine ones, this is the greatest difference anywhere. In 1/8 quanta, exact; both height matrices
// are n x n.
std::int64_t max_deviation(const std::int32_t* coarse, const Half& coarse_half, const std::int32_t* fine,
                           const Half& fine_half, int n);

// Bound of the 3-D distance between the flat patch of a half and S beneath one leaf, or in general between
// flat triangles and a surface of the same vertices with heights linear in lattice coordinates, metres.
double flat_patch_bound(const Ellipsoid& body, const Half& half, const HeightRange& range, double quantum,
                        int cells);

}  // namespace carat
