// Which diamonds are refined.
#pragma once

#include "build_levels.hpp"
#include "build_progress.hpp"

namespace carat {

RefinedLevels plan_depth(const BuildOptions& options, const SourceStack& sources, ProgressReporter& progress);

// Those of `candidates`, of one level, that are coarser than the sources inside them.
std::vector<DiamondId> too_coarse(const std::vector<DiamondId>& candidates, const BuildOptions& options,
                                  const SourceStack& sources, ProgressReporter& progress);
// No diamond of this level or deeper is refined.
int end_of_levels(const BuildOptions& options);

}  // namespace carat
