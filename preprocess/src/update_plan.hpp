// How deep an updated file goes: what the new layer has no say in stays as it is.
#pragma once

#include "build_levels.hpp"
#include "build_progress.hpp"
#include "carat/preprocess/build.hpp"

namespace carat {

struct UpdatePlan {
    RefinedLevels levels;          // all refined diamonds of the new file, as plan_depth() would give them
    RefinedLevels near;            // of these all that the new layer may have a say in
    RefinedLevels added, removed;  // against the old file
};

// before: the refined diamonds of the file that was built from all `sources` but `layer`. Asks the sources
// only where that layer has a say; time is that and a few nanoseconds a diamond of the old file.
UpdatePlan plan_update(const BuildOptions& options, const SourceStack& sources, std::size_t layer,
                       const RefinedLevels& before, ProgressReporter& progress);
// The same for levels that are known, everything being near.
UpdatePlan whole_update(RefinedLevels levels, const RefinedLevels& before);

}  // namespace carat
