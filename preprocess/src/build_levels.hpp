// The refined diamonds of a build, by level, and how a level is cut into steps.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "carat/globe/diamond.hpp"

namespace carat {

// Refined diamonds by level, each level in the order of DiamondId. The set is closed upwards.
using RefinedLevels = std::vector<std::vector<DiamondId>>;

// A step: this many consecutive diamonds of a level, a fact of the temporary files. 512 diamonds of 65 x 65
// take at most 17 MB.
inline constexpr std::size_t kStepDiamonds = 512;

inline std::size_t step_count(std::size_t diamonds) { return (diamonds + kStepDiamonds - 1) / kStepDiamonds; }

// Where a diamond stands in its level; nothing if it is not refined.
inline std::optional<std::size_t> position_of(const RefinedLevels& levels, DiamondId d, int level) {
    if (level < 0 || level >= static_cast<int>(levels.size())) return std::nullopt;
    const auto& ids = levels[static_cast<std::size_t>(level)];
    const auto it = std::lower_bound(ids.begin(), ids.end(), d);
    if (it == ids.end() || *it != d) return std::nullopt;
    return static_cast<std::size_t>(it - ids.begin());
}

}  // namespace carat
