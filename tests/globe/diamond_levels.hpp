// All diamonds of the levels that are tested exhaustively, and random ones of every level.
#pragma once

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "carat/globe/diamond.hpp"
#include "design_diamond.hpp"

namespace carat::test {

inline constexpr int kExhaustive = 9;

// Every diamond of levels 0..kExhaustive, by following children from the six faces.
inline const std::vector<std::set<DiamondId>>& all_levels() {
    static const std::vector<std::set<DiamondId>> levels = [] {
        std::vector<std::set<DiamondId>> out(kExhaustive + 1);
        for (int face = 0; face < kFaces; ++face) out[0].insert(root_diamond(face));
        for (std::size_t l = 0; l < kExhaustive; ++l)
            for (const DiamondId d : out[l])
                for (const DiamondId k : children(d)) out[l + 1].insert(k);
        return out;
    }();
    return levels;
}

template <class Visit>
void for_all(Visit visit) {
    for (std::size_t l = 0; l <= kExhaustive; ++l)
        for (const DiamondId d : all_levels()[l]) visit(d, static_cast<int>(l));
}

// Two hundred of each level from 0 to the last.
template <class Visit>
void for_random(int last_level, Visit visit) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int level = 0; level <= last_level; ++level)
        for (int n = 0; n < 200; ++n) visit(random_diamond(random, level), level);
}

}  // namespace carat::test
