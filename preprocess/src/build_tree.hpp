// The diamonds of a build, in memory.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "carat/codec/codec.hpp"
#include "carat/preprocess/build.hpp"

namespace carat {

// A refined diamond on its way through the passes.
struct BuildDiamond {
    DiamondId id;
    std::vector<std::int32_t> p;  // reconstructed vertices, N x N
    RefinedHeights refined;       // first the reference (modes 1, 2), then the reconstruction
    EncodedResiduals residuals;
    std::array<SummaryValues, 2> summary;
};

// All refined diamonds by level, each level in the order of DiamondId. The set is closed upwards.
struct BuildTree {
    std::vector<std::vector<BuildDiamond>> levels;

    int depth() const { return static_cast<int>(levels.size()); }  // deepest refined level + 1
    BuildDiamond* find(DiamondId d);
    const BuildDiamond* find(DiamondId d) const { return const_cast<BuildTree*>(this)->find(d); }
    // Builds the index; call after levels are filled and before find.
    void index();
    std::uint64_t count() const;

  private:
    std::unordered_map<DiamondId, BuildDiamond*, DiamondIdHash> index_;
};

// Heights of a half that exists in the tree: its own diamond's P if refined, else gathered from the parent
// into `scratch` (N x N). Level-0 diamonds that are not refined are not asked for.
const std::int32_t* half_heights(const BuildTree& tree, const Half& half, int n,
                                 std::vector<std::int32_t>& scratch);

}  // namespace carat
