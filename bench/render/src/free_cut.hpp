// The least conforming cut for any notion of what demands refinement.
#pragma once

#include <functional>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "carat/codec/repository.hpp"

namespace carat::bench {

struct FreeHalf {
    Half half;
    Half of_file;  // the half of the file that holds its surface: itself, or the leaf that it is a part of

    bool is_virtual() const { return half != of_file; }
};

// demands: a pure function of the half. Nothing if more than `most` diamonds are refined.
std::optional<std::vector<FreeHalf>> least_cut(const Repository& file,
                                               const std::function<bool(const FreeHalf&)>& demands,
                                               std::size_t most);

}  // namespace carat::bench
