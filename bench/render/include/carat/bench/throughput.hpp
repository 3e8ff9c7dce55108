// How fast diamonds are refined: residuals decoded, heights handed to the children, patches built.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "carat/codec/repository.hpp"

namespace carat::bench {

struct ThroughputRow {
    int threads = 0;
    double diamonds_per_second = 0;
    double samples_per_second = 0;       // heights that the parents' patches did not show
    double samples_per_core_second = 0;  // the same by the processor time of the threads, not the clock's
    double vertices_per_second = 0;      // of patches built
    double decode_share = 0;             // of the time: residuals, heights of the children, bounds
    double build_share = 0;              // positions and normals
};

struct Throughput {
    std::uint64_t diamonds = 0;        // in one round
    double bytes_a_diamond = 0;        // read, made and written: residuals, heights and vertices
    double copy_bytes_per_second = 0;  // memcpy of as many bytes in blocks of a diamond's, a core's second
    std::vector<ThroughputRow> rows;
};

struct ThroughputOptions {
    std::vector<int> threads{1, 2};
    int diamonds = 1500;  // a round, drawn evenly from the finest levels that hold so many
    int rounds = 5;       // the best one counts
};

// Everything is in memory before the clock starts: pages, parents' heights.
Throughput measure_throughput(const std::shared_ptr<const Repository>& repository,
                              const ThroughputOptions& options = {});

}  // namespace carat::bench
