// How much the summaries of a file overestimate, on real terrain.
//
// delta of a half bounds the distance between the flat patch drawn there and the surface S. Exact here: the
// greatest distance, over all leaf vertices below the half, between the point of S and the point of the flat
// patch at the same place of the lattice. (Between leaf vertices S differs from its chords by the leaf's
// sagitta, millimetres to centimetres, so this is very nearly the supremum and never above it: the ratios are
// not flattered.)
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "carat/codec/repository.hpp"

namespace carat::bench {

struct SummaryRow {
    int level = 0;
    std::size_t halves = 0;  // compared, of all refined ones
    std::size_t refined = 0;
    double spacing = 0;                          // median, metres between the half's vertices
    double exact = 0;                            // median, metres
    double least = 0, median = 0, greatest = 0;  // delta / exact
    double range_median = 0;  // median of (max - min) of the summary / of the leaf heights below, where they
                              // reach the tolerance
    std::size_t violations = 0;  // delta below exact, or heights outside min and max: must be 0
};

struct SummaryBenchOptions {
    std::size_t vertices_per_level = 20'000'000;  // bounds the work; at least one half a level is compared
    // Called now and then; false throws Error(usage) "cancelled".
    std::function<bool(std::size_t done, std::size_t total)> progress = {};
};

// One row for each level with refined diamonds. Decodes much of the file.
std::vector<SummaryRow> bench_summaries(const std::shared_ptr<const Repository>& file,
                                        const SummaryBenchOptions& options);

}  // namespace carat::bench
