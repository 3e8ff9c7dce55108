// What a build should come to, before it is done.
#pragma once

#include "build_levels.hpp"
#include "carat/preprocess/build.hpp"

namespace carat {

// Codes some of the diamonds, evenly spread over the list of all, from rounded source heights. Throws what
// reading the sources throws.
BuildEstimate estimate_build(const BuildOptions& options, const SourceStack& sources,
                             const RefinedLevels& levels, const BuildPlan& plan);

}  // namespace carat
