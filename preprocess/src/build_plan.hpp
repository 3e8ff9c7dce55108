// Which diamonds are refined.
#pragma once

#include <vector>

#include "build_progress.hpp"
#include "carat/globe/diamond.hpp"

namespace carat {

// Refined diamonds by level, sorted, closed upwards.
using RefinedLevels = std::vector<std::vector<DiamondId>>;

RefinedLevels plan_depth(const BuildOptions& options, const SourceStack& sources, ProgressReporter& progress);

}  // namespace carat
