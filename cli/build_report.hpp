// What a build will do or has done, as text or JSON on stdout.
#pragma once

#include "carat/preprocess/build.hpp"

namespace carat::cli {

void print_plan(const BuildPlan& plan, const BuildOptions& options, bool json);
void print_report(const BuildReport& report, const BuildOptions& options, bool json);

}  // namespace carat::cli
