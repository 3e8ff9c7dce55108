// Updating a repository: a layer more, without building everything again.
//
//   result    byte for byte what a full build with the new list of layers and the file's own options and
//   coder tables
//             would write
//   closure   the diamonds that are worked out anew: those where the new layer may have heights, those that
//   are refined
//             now and were not, and those whose vertices have changed because a diamond above has changed
//             (near-lossless prediction carries a change a few cells sideways)
//   the rest  keeps its residuals and, unless something changes below, its summaries; neither is decoded
//   sources   the old ones are needed where the closure is, and must be what the file was built from: each is
//             opened, hashed and compared with the file's record. They are looked through for holes, and
//             their blocks are decoded, only where the closure has samples
//   time      that of the closure's diamonds, of the source blocks under their samples (coarse ones lie
//             in many), of hashing the sources, and of a copy of the file
//
// A file that promises an RMS error is refused: its step hangs on all of the data.
// Modes 1 and 2 filter from the finest level up, so that a change reaches everything above it: these files,
// and updates whose closure does not fit into memory, are built anew as a whole (UpdateReport::full).
#pragma once

#include "carat/preprocess/build.hpp"

namespace carat {

struct UpdateOptions {
    std::filesystem::path file;
    LayerOptions layer;
    int at =
        1;  // place of the layer in the order of priority: 1 above all, one more than there are below all
    // Folders with the old sources, by their recorded names, in this order; then the file's own and the
    // current one.
    std::vector<std::filesystem::path> sources;
    std::filesystem::path output;  // empty: replaces the file
    bool overwrite = false;        // an output that exists
    // Compare the result with every source sample and record the errors, as a build does. Takes as long as
    // reading all sources. Implied if the file was built with BuildOptions::certify.
    bool measure = false;
    // Compare the old sources' sizes only, not their contents, with what the file records: they need not be
    // read as a whole then. A source that has changed and kept its size goes unnoticed, and the result is not
    // what a full build gives.
    bool trust_sources = false;
    int threads = 0;
    std::size_t memory_bytes = 0;
    std::filesystem::path temp;  // for updates that build anew
};

struct UpdateReport {
    BuildPlan plan;
    bool full = false;            // built anew as a whole
    std::uint64_t added = 0;      // diamonds refined now and not before
    std::uint64_t removed = 0;    // refined before and not now
    std::uint64_t recoded = 0;    // the closure, the added included
    std::uint64_t changed = 0;    // of the recoded, those that came out different or are new
    std::uint64_t copied = 0;     // diamonds whose residuals were copied
    std::uint64_t summaries = 0;  // halves whose summaries were worked out anew
    std::uint64_t file_bytes = 0;
    std::uint64_t source_tiles = 0, tile_reads = 0;  // as SourceStack::Reads
    std::optional<Certification> certification;
    std::optional<ErrorSummary> errors;
    double seconds = 0;
    std::vector<std::pair<BuildStage, double>> stage_seconds;
    std::uint64_t peak_memory_bytes = 0;
};

// Throws Error: usage (a source is missing or has changed, at is out of range, output exists), and what
// building and reading throw. On failure the file is as it was.
UpdateReport update_repository(const UpdateOptions& options, const ProgressFunction& progress = {});

}  // namespace carat
