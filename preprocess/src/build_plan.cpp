#include "build_plan.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "carat/globe/bounds.hpp"

namespace carat {
namespace {

void sort_unique(std::vector<DiamondId>& ids) {
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

}  // namespace

std::vector<DiamondId> too_coarse(const std::vector<DiamondId>& candidates, const BuildOptions& options,
                                  const SourceStack& sources, ProgressReporter& progress) {
    const double bias = std::exp2(-0.5 * options.depth_bias);
    const int cells = 1 << options.log2_cells;
    std::vector<std::uint8_t> wanted(candidates.size());
    tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t k) {
        const DiamondId d = candidates[k];
        wanted[k] = sample_spacing(options.body, d, cells) > bias * sources.finest_spacing(d) ? 1 : 0;
        progress.step();
    });
    std::vector<DiamondId> out;
    for (std::size_t k = 0; k < candidates.size(); ++k)
        if (wanted[k] != 0) out.push_back(candidates[k]);
    return out;
}

int end_of_levels(const BuildOptions& options) {
    return std::min({options.max_level, deepest_level(options.log2_cells), kDeepestId});
}

RefinedLevels plan_depth(const BuildOptions& options, const SourceStack& sources,
                         ProgressReporter& progress) {
    RefinedLevels levels;
    const int end_level = end_of_levels(options);
    std::vector<DiamondId> candidates;
    for (int face = 0; face < kFaces; ++face) candidates.push_back(root_diamond(face));
    // A diamond that is too coarse for data inside it has a parent that holds the same data and is coarser
    // still, so the children of the wanted are candidates enough.
    for (int level = 0; level < end_level && !candidates.empty(); ++level) {
        std::vector<DiamondId> wanted = too_coarse(candidates, options, sources, progress);
        candidates.clear();
        for (const DiamondId d : wanted)
            for (const DiamondId k : children(d)) candidates.push_back(k);
        sort_unique(candidates);
        if (!wanted.empty()) levels.push_back(std::move(wanted));
    }
    for (std::size_t level = levels.size(); level-- > 1;) {
        auto& above = levels[level - 1];
        for (const DiamondId d : levels[level])
            for (const int side : {0, 1}) above.push_back(*parent(d, side));
        sort_unique(above);
    }
    return levels;
}

}  // namespace carat
