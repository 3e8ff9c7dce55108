// How far the reconstructed surface S lies from the sources, at every sample of the sources themselves.
//
// A file's tolerance bounds S at lattice points. Source samples lie between them, so the error there contains
// what resampling costs; it is not bounded, it is measured:
//
//   compared   valid samples that alone give the height at their place (the layer wins there, no other layer
//   has a share):
//              S - sample
//   blended    samples in feathered zones: S - what the layers blend to there
//   hidden     samples below a layer of higher priority: counted, not compared
//
// A sample's place is the middle of its pixel. A row of samples at a pole is one sample, its mean.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "carat/codec/repository.hpp"
#include "carat/preprocess/source.hpp"

namespace carat {

// Errors of a set of samples, metres. Percentiles are rounded up, by at most 1.6 % of their value (or 2^-16
// m).
struct ErrorStats {
    std::uint64_t count = 0;
    double max = 0, rms = 0, mean = 0;           // of |S - h|, of squares, and of S - h with its sign
    double p50 = 0, p90 = 0, p99 = 0, p999 = 0;  // of |S - h|
};

// Where S is far off.
struct WorstPlace {
    double latitude = 0, longitude = 0;  // degrees, geodetic
    double source = 0, surface = 0;      // metres
};

struct LayerErrors {
    std::string name;
    ErrorStats compared, blended;
    std::uint64_t hidden = 0;
    std::vector<WorstPlace>
        worst;  // of the compared, largest first, no two from one block of 256 x 256 samples
};

struct ErrorSummary {
    std::vector<LayerErrors> layers;
    ErrorStats all;  // compared samples of all layers
};

struct MeasureOptions {
    int threads = 0;                        // 0: all
    std::size_t memory_bytes = 256u << 20;  // for decoded diamonds
    std::size_t worst_places = 10;          // listed for each layer
    // Called from one thread at a time with the samples looked at; returning false throws Error(usage)
    // "cancelled".
    std::function<bool(std::uint64_t done, std::uint64_t total)> progress = {};
};

// The result depends on sources and file alone, to the last bit. Throws what reading either throws;
// Error(usage) if they speak of different bodies.
ErrorSummary measure_errors(const SourceStack& sources, std::shared_ptr<const Repository> file,
                            const MeasureOptions& options = {});

// As it stands in a file's provenance, under "source_errors"; compact. Throws Error(corrupt) for what to_json
// did not write.
std::string to_json(const ErrorSummary& summary);
ErrorSummary error_summary_of_json(const std::string& json);

}  // namespace carat
