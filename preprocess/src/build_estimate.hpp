// What a build should come to, before it is done.
#pragma once

#include "build_levels.hpp"
#include "carat/preprocess/build.hpp"

namespace carat {

// For a build that is going to be done: one of 48 diamonds, at least 16.
std::size_t trials_before_build(const BuildPlan& plan);
inline constexpr std::size_t kMostTrials = 192;

// Codes at most `trials` of the diamonds, evenly spread over the list of all, from rounded source heights.
// Throws what reading the sources throws.
BuildEstimate estimate_build(const BuildOptions& options, const SourceStack& sources,
                             const RefinedLevels& levels, const BuildPlan& plan,
                             std::size_t trials = kMostTrials);

}  // namespace carat
