// The converged cut: which diamonds are refined, and the halves that are left to draw.
//
// A set R of diamonds is a cut if it is closed upwards: a refined diamond has both parents refined. A half
// exists if it is on level 0 or its parent diamond (the one centred at its right-angled corner) is in R; the
// frontier is the existing halves of diamonds not in R, and tiles the sphere conformingly. A half *demands*
// refinement if it is not culled and its screen error exceeds the threshold; both are pure functions of
// (file, view, threshold, half). Cuts whose existing demanding halves are all of refined diamonds are closed
// under intersection, so there is a least one, and that is the converged cut: a pure function too, whatever
// the order of work or the number of threads.
//
// A diamond that the file refines is decoded; one below the file's leaves is refined virtually
// (half_heights.hpp). Halves of the file are judged by their stored summaries, before anything is decoded;
// virtual halves, and leaves whose summary demands refinement, by their own heights.
#pragma once

#include <cstdint>
#include <vector>

#include "carat/codec/colour.hpp"
#include "carat/codec/repository.hpp"
#include "carat/render/detail.hpp"
#include "carat/render/half_heights.hpp"
#include "carat/render/visibility.hpp"

namespace carat {

struct CutCounters {
    std::uint64_t halves_tested = 0;    // judged against the view
    std::uint64_t culled_frustum = 0;   // of these, found off the screen
    std::uint64_t culled_horizon = 0;   // of these, found behind the horizon
    std::uint64_t refined = 0;          // diamonds in the cut
    std::uint64_t decoded = 0;          // of these, refined by the file
    std::uint64_t virtual_refined = 0;  // of these, refined virtually
    std::uint64_t patches = 0;          // frontier halves to draw
    std::uint64_t triangles = 0;        // in these
    std::uint64_t limited = 0;          // of these, above the threshold on the deepest level
    double worst_error = 0;             // pixels, greatest screen error among the patches
    double selection_ms = 0, decode_ms = 0, build_ms = 0;  // wall time
    ReadCounters read;                                     // what the repository read for this cut
};

struct FrontierHalf {
    Half half;
    Culled culled = Culled::none;
    bool is_virtual = false;  // below the file's leaves
    double error = 0;         // pixels; 0 if culled
    double delta = 0;         // metres: bound of the distance between the flat patch and S; 0 if culled
    HalfHeights heights;      // empty if culled
};

struct Cut {
    std::vector<DiamondId> refined;      // sorted
    std::vector<FrontierHalf> frontier;  // sorted by half; culled ones included
    CutCounters counters;                // all but build_ms
};

// Greatest cut: 100,000 frontier halves, 1.7 GB of heights for 65 x 65 diamonds.
inline constexpr std::uint64_t kMaxRefined = 50'000;

// threshold in pixels, > 0; else throws Error(usage). spacing, pixels, >= 0: a half that the file refines
// demands refinement also while its samples lie further apart on screen, for the sake of the colours and
// slopes drawn on it; 0: geometry alone decides. Throws Error(limit) above kMaxRefined diamonds, and what the
// repository throws. Uses the threads of the current TBB arena. Peak memory: 17 KiB a frontier half for
// 65 x 65 diamonds, and one decoded diamond a thread.
// colour, if not null: what it refines demands refinement for the spacing of its samples too, below the
// file's leaves virtually.
// detail, if not null, is part of the surface below the file's leaves: in heights, bounds and demands. The
// visibility's heights must hold it too (Detail::greatest()).
Cut select_cut(const Repository& repository, const Visibility& visibility, double threshold,
               double spacing = 0, const ColourRepository* colour = nullptr, const Detail* detail = nullptr);

// The deepest level whose diamonds can be refined, for N = 2^p + 1.
int deepest_refinable_level(int p);

// Upper bound, metres, of the distance between the flat patch of a half at or below the leaves and S, from
// the half's own heights.
double leaf_delta(const Ellipsoid& body, const Half& half, const HalfRange& range, int cells);
double leaf_delta(const CurvatureBound& curvature, const HalfRange& range);  // the half's, of its cells

}  // namespace carat
