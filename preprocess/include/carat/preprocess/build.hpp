// The builder: source heights in, a repository file out.
//
//   depth     a diamond is refined while its spacing exceeds the finest source spacing somewhere inside it
//   (times
//             2^(depth_bias/2)); its parents with it, so that the refined set is closed upwards
//   samples   source heights are taken at the lattice points of the leaves, rounded to the quantum
//   passes    fine to coarse: sampling, and filtering (modes 1 and 2); coarse to fine: coding; fine to
//   coarse:
//             summaries
//   memory    what the passes hand on lies in temporary files, in steps of 512 diamonds; peak resident memory
//   stays
//             below BuildOptions::memory_bytes
//   resuming  a step's file is there only when it is complete; a build that was killed skips the steps that
//   are
//             there. Temporary files depend on inputs and options alone
//   threads   parallel over the diamonds of a step; the bytes do not depend on their number, on memory or
//   resuming
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "carat/codec/diamond_codec.hpp"
#include "carat/globe/ellipsoid.hpp"
#include "carat/preprocess/layer.hpp"
#include "carat/preprocess/measure.hpp"
#include "carat/preprocess/source.hpp"

namespace carat {

struct BuildOptions {
    std::vector<LayerOptions> layers;  // in priority order
    double tolerance = 1;              // metres: greatest |reconstructed - source| at lattice points
    std::optional<double> quantum;     // metres; default: default_quantum(tolerance)
    Ellipsoid body = Ellipsoid::earth();
    std::string vertical_datum = "unstated";
    double base_height = 0;  // metres, where no layer has data
    Mode mode = Mode::interpolating;
    Coding coding;  // coder, prediction orders and tables
    // Metres, below the tolerance: root mean square of reconstructed - source over the values at lattice
    // points that residuals are coded for. The step is the greatest that keeps it, and the file promises it.
    std::optional<double> rms;
    // Range coder: tables fitted to a sample of the diamonds, stored in the file where they save more than
    // they take.
    bool fit_tables = false;
    double depth_bias =
        0;  // levels added (or, if negative, left out): a level is a factor of sqrt(2) in spacing
    int max_level = 40;  // no diamond of this level or deeper is refined
    int log2_cells = 6;
    int threads = 0;               // 0: all
    std::size_t memory_bytes = 0;  // peak resident memory; 0: a quarter of the machine's
    // Metres, above the tolerance: refine until |S - sample| is at most this at every compared source sample
    // (measure.hpp), as far as max_level allows. Mode 0 only. Implies measure.
    std::optional<double> certify;
    bool overwrite = false;
    bool measure = true;  // compare the result with every source sample and record the errors (measure.hpp)
    bool resume = false;  // go on with what a killed or cancelled build of the same inputs left
    std::filesystem::path temp;  // folder for temporary files; empty: OUTPUT.build beside the output

    std::filesystem::path output;

    bool measures() const { return measure || certify.has_value(); }
};

// Stages of a build, for progress bars. done and total count diamonds, while certifying and measuring source
// samples.
enum class BuildStage { opening, planning, certifying, sampling, coding, summarising, writing, measuring };
const char* to_string(BuildStage stage);

struct BuildProgress {
    BuildStage stage = BuildStage::opening;
    std::uint64_t done = 0, total = 0;
};
// Called from one thread at a time, at most about ten times a second. Returning false cancels: Error(usage)
// "cancelled" is thrown, and only the temporary folder is left, for BuildOptions::resume.
using ProgressFunction = std::function<bool(const BuildProgress&)>;

// Refined diamonds by the layer that has samples at their centres (SourceStack::layer_near).
struct LayerShare {
    std::uint64_t refined = 0, zero = 0;  // zero: without residuals
    std::uint64_t residual_bytes = 0;
};

// What a build should come to, from some of its diamonds, evenly spread over the list of all.
struct BuildEstimate {
    std::size_t sampled = 0;  // diamonds
    std::uint64_t file_bytes = 0;
    // On this machine if nothing else runs, the comparison with source samples included if it is asked for.
    double seconds = 0;
};

// What a build will do or has done.
struct BuildPlan {
    std::vector<LayerInfo> layers;
    std::vector<LayerShare> shares;         // of each layer, last of the base height; empty before the build
    std::optional<BuildEstimate> estimate;  // not if a build is resumed
    std::vector<std::string> warnings;
    std::vector<std::uint64_t> refined_by_level;
    std::uint64_t refined = 0;
    std::uint64_t leaf_samples = 0;     // distinct lattice points with a coded height
    std::uint64_t source_samples = 0;   // valid samples of all layers
    std::uint64_t temporary_bytes = 0;  // temporary files take at most this
    std::filesystem::path temporary_folder;
};

// What BuildOptions::certify led to.
struct Certification {
    double bound = 0;               // metres
    std::uint64_t samples = 0;      // compared
    std::uint64_t beyond = 0;       // of these, beyond the bound still, for the depth is limited
    std::uint64_t added = 0;        // diamonds refined for the certificate
    int rounds = 0;                 // of checking and refining
    std::vector<WorstPlace> worst;  // beyond the bound, largest first; surface is the unquantised one

    bool reached() const { return beyond == 0; }
};

struct BuildReport {
    BuildPlan plan;
    std::uint64_t file_bytes = 0;
    std::uint64_t coded_diamonds = 0, zero_diamonds = 0;
    double tolerance = 0;                 // metres, that of the file
    double max_error = 0, rms_error = 0;  // metres, at lattice points, rounding to the quantum included;
                                          // NaN if already_complete
    std::optional<Certification> certification;
    std::optional<ErrorSummary> errors;      // at source samples, if they were measured
    std::uint64_t temporary_peak_bytes = 0;  // of temporary files, while this ran
    std::uint64_t peak_memory_bytes = 0;     // resident, of the process, as the operating system tells
    // Tiles of source samples (a file's own blocks, or a few of them), and how often one was read and decoded
    // while sampling and while measuring: once each, unless memory is scarce.
    std::uint64_t source_tiles = 0, sampling_tile_reads = 0, measuring_tile_reads = 0;
    std::size_t resumed_files = 0;  // temporary files that an earlier run had left
    bool already_complete = false;  // an earlier run had finished the output; resume found nothing to do
    double seconds = 0;
    std::vector<std::pair<BuildStage, double>> stage_seconds;
};

// Opens the sources and finds the refined diamonds; writes nothing (--dry-run).
BuildPlan plan_build(const BuildOptions& options, const ProgressFunction& progress = {});
// Throws Error: usage (options, output exists), io, limit, and what SourceStack throws.
// With BuildOptions::resume an output that says of itself what this build would say is not built again:
// the run that was killed had finished it.
// After a failure of reading or writing, a full disk for one, the temporary folder is kept for
// BuildOptions::resume; after others nothing is left. planned, if given, is called before the work begins.
BuildReport build_repository(const BuildOptions& options, const ProgressFunction& progress = {},
                             const std::function<void(const BuildPlan&)>& planned = {});

}  // namespace carat
