// A surface against the sources, block by block of the sources' samples.
#pragma once

#include <functional>
#include <vector>

#include "carat/preprocess/measure.hpp"
#include "leaf_surface.hpp"
#include "source_samples.hpp"

namespace carat {

// Samples looked at, hidden and holes included; called from any thread. May throw to end the work.
using SampleStep = std::function<void(std::uint64_t samples)>;

std::uint64_t samples_in(const std::vector<SampleBlock>& blocks);

ErrorSummary measure_blocks(const SourceStack& sources, const LeafSurface& surface, std::size_t worst_places,
                            const SampleStep& step);

}  // namespace carat
