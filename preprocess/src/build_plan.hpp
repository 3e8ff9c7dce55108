// Which diamonds are refined.
#pragma once

#include "build_levels.hpp"
#include "build_progress.hpp"

namespace carat {

RefinedLevels plan_depth(const BuildOptions& options, const SourceStack& sources, ProgressReporter& progress);

}  // namespace carat
