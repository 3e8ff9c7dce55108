// The end of a build or an update: what the file says of itself, its pages, its errors at source samples.
#pragma once

#include <span>

#include "build_levels.hpp"
#include "build_progress.hpp"
#include "carat/codec/codec.hpp"
#include "carat/preprocess/build.hpp"

namespace carat {

struct OutputJob {
    const BuildOptions& options;
    const SourceStack& sources;
    double quantum;
    std::int32_t radius;
    ProgressReporter& progress;
    std::size_t cache_bytes;  // for decoded heights while errors are measured
};

// What a build of these diamonds comes to, shares and estimate excepted.
BuildPlan describe_plan(const SourceStack& sources, const RefinedLevels& levels, int cells);

// Writes the file, measures its errors if the options ask for it, and lets it appear under its name; returns
// its bytes. diamonds: level by level in the order of ids. Fills in plan.shares if it is empty and, if
// measured, errors.
std::uint64_t write_output(const OutputJob& job, BuildPlan& plan,
                           const std::optional<Certification>& certification, const EncodedRoots& roots,
                           std::span<const DiamondEntry> diamonds, const BlobSource& blobs,
                           std::optional<ErrorSummary>& errors, const OldPages& old = {});

}  // namespace carat
