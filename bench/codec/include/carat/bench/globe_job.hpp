// The same job: a whole .carat file of the globe out of a raster, against the raster's own samples.
//
// What a user pays for a file: all levels of detail, summaries, pages and directory, on a lattice that is not
// the raster's. Peers store the raster's samples and nothing else: their rows "none" of the other table.
#pragma once

#include <optional>
#include <string>

#include "carat/bench/raster.hpp"
#include "carat/globe/ellipsoid.hpp"
#include "carat/preprocess/build.hpp"

namespace carat::bench {

struct GlobeRow {
    std::string coder;
    double tolerance = 0;  // metres, at lattice points
    std::uint64_t file_bytes = 0, source_samples = 0, leaf_samples = 0;
    double bits_per_source_sample = 0;
    std::uint64_t diamonds = 0, index_bytes = 0;  // refined; of pages and directory, all but residuals
    Errors at_lattice;                            // metres
    Errors at_source;                             // metres: |S - sample| at the valid samples of the source
    double p99_at_source = 0;
    double build_seconds = 0;  // one thread
};

const std::vector<std::string>& globe_coders();

// Builds into a temporary folder. The raster must be georeferenced. Throws what build_repository throws.
GlobeRow bench_globe(const std::string& file, const std::optional<Crop>& crop, const Ellipsoid& body,
                     const std::string& coder, double tolerance, const ProgressFunction& progress);

}  // namespace carat::bench
