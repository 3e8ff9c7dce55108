// The comparison itself: every contestant at every tolerance on the same samples, one thread, in one run.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "carat/bench/contestant.hpp"
#include "carat/bench/raster.hpp"

namespace carat::bench {

struct CodecBenchOptions {
    std::vector<double> tolerances{0.5, 1, 4, 16};  // metres
    std::vector<std::string> codecs;                // names or their beginnings; empty: all
    int tile = 256;                                 // samples a side; 0: no tiles
    int repeats = 3;  // timings are medians of the thread's own seconds; 5 s are not repeated
    // Called before each measurement; false throws Error(usage) "cancelled".
    std::function<bool(const std::string& what, std::size_t done, std::size_t total)> progress = {};
};

struct CodecRow {
    std::string codec, unit;  // unit of random access
    double tolerance = 0;
    std::string failure;  // not empty: the codec could not, and why
    std::size_t bytes = 0;
    double bits_per_sample = 0;
    Errors errors;                            // measured, of the decoded samples
    bool within = false;                      // the promise is kept
    double encode_rate = 0, decode_rate = 0;  // samples a second
    double decode_cycles = 0;                 // time stamp cycles a sample
    double decode_bytes_per_cycle = 0;        // bytes of samples written
    std::vector<double> decode_shares;
};

struct CodecTable {
    std::vector<CodecRow> rows;
    double copy_bytes_per_cycle = 0;  // memcpy of the samples, same run
    double cycles_per_second = 0;
};

// Throws Error(usage) if no codec has such a name.
CodecTable bench_codecs(const Raster& raster, const CodecBenchOptions& options);

}  // namespace carat::bench
