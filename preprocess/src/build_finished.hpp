// A build that was killed after its output had got its name, before its temporary files were gone.
#pragma once

#include <optional>

#include "carat/preprocess/build.hpp"

namespace carat {

// What is known of the output if it is there and says of itself what this build would say; its temporary
// files, if any are left, are removed. options: as asked for, before steps or tables are chosen. Throws
// Error(usage) if another process uses the temporary files.
std::optional<BuildReport> finished_before(const BuildOptions& options, const BuildPlan& plan,
                                           const std::optional<Certification>& certification);

}  // namespace carat
