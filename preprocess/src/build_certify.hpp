// Depth that a certificate asks for: refinement until the surface through unquantised source heights is near
// every source sample.
#pragma once

#include "build_plan.hpp"
#include "carat/preprocess/build.hpp"

namespace carat {

// Refines `levels` further, and keeps them closed upwards, until |S0 - h| <= options.certify -
// options.tolerance at every compared sample (measure.hpp), S0 being the surface of the leaves through
// unquantised source heights. As every height of S is within the tolerance of S0's, and S is a weighted mean
// of three of them, |S - h| <= options.certify then. Diamonds of options.max_level and deeper are not
// refined; samples that this leaves too far off are listed. Precondition: options.certify is set.
// Thread-safe, the result does not depend on threads.
Certification certify_depth(const BuildOptions& options, const SourceStack& sources, RefinedLevels& levels,
                            ProgressReporter& progress);

}  // namespace carat
