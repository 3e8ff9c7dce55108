// What a build decides from a sample of its diamonds before anything is coded: the step that keeps an RMS
// error, and the tables of the range coder.
#pragma once

#include "build_levels.hpp"
#include "carat/preprocess/build.hpp"

namespace carat {

// The options that the passes go by: with `rms`, quantum and tolerance are set so that the sample keeps it,
// with `fit_tables` the coding has tables of its own. Depends on sources and options alone. Throws
// Error(usage) for an RMS that no step can keep, and what reading the sources throws.
BuildOptions chosen_options(const BuildOptions& options, const SourceStack& sources,
                            const RefinedLevels& levels);

// The options with the greatest tolerance that is likely to keep the RMS error, after one that led to `found`
// metres. Throws Error(usage) if there is no smaller one.
BuildOptions with_smaller_step(const BuildOptions& options, double found);

// Of options with a quantum: the greatest error that they allow, metres, for the quantiser's radius.
double tolerance_of(std::int32_t radius, double quantum);

}  // namespace carat
