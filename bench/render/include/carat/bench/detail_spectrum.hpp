// Does procedural detail go on as the data do, and how fast is it made?
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "carat/codec/repository.hpp"
#include "carat/render/detail.hpp"

namespace carat::bench {

struct DetailBenchOptions {
    DetailOptions detail;
    std::optional<std::array<double, 4>>
        bounds;  // W, S, E, N: where leaves are drawn from; default: anywhere
    int leaves = 150;
    int rounds = 5;  // of the rates; the best counts
    std::uint64_t seed = 1;
};

struct SpectrumRow {
    double wavelength = 0;  // in spacings of the leaf
    double before = 0;      // mean power density of S along a row, metres^2 spacings
    double after = 0;       // of S with detail
};

struct DetailSpectrum {
    std::uint64_t leaves = 0, profiles = 0;
    std::vector<SpectrumRow> rows;  // long waves first, a third of an octave each
    // Power ~ wavelength^slope, by least squares: over 32 to 4 spacings, which the data decide, and over 1 to
    // 1/4, which detail does.
    double data_slope = 0, before_slope = 0, detail_slope = 0;
    // Mean power with detail at 1 spacing and below, over what the data's line says there; 1: no step.
    double continued = 0;
    // New samples a second of processor time on one core, children's heights gathered: the leaves' parents
    // decoded, the leaves synthesised.
    double decoded_per_second = 0, synthesised_per_second = 0;
};

// Profiles run along rows of the leaves, a window of Hann's over each. Throws Error(usage) if there is no
// leaf within the bounds, and what the repository throws.
DetailSpectrum measure_detail(const std::shared_ptr<const Repository>& repository,
                              const DetailBenchOptions& options);

}  // namespace carat::bench
