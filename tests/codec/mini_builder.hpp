// A whole small repository, built in memory from a function of the lattice point, with everything a test
// compares with: the reference heights of every level, what the encoder reconstructed, and the exact
// summaries.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "carat/codec/repository.hpp"
#include "carat/codec/writer.hpp"
#include "fields.hpp"

namespace carat::test {

struct MiniPlan {
    Field source = constant(0);
    int log2_cells = 4;
    double quantum = 1.0 / 256, tolerance = 1;
    Ellipsoid body = Ellipsoid::earth();
    int depth = 3;                                   // no diamond of this level or deeper is refined
    std::function<bool(DiamondId)> refine = {};      // which to refine, with all their ancestors; empty: all
    std::function<Mode(DiamondId)> mode = {};        // empty: interpolating
    Coding coding = Coding::paper();                 // gamma, order 4
    std::function<unsigned(DiamondId)> orders = {};  // as Coding::orders; empty: coding's
    RangeStatistics* statistics = nullptr;
    std::string vertical_datum = "unstated", provenance = "{}";

    int n() const { return (1 << log2_cells) + 1; }
};

using Grid = std::vector<std::int32_t>;  // n x n

struct MiniBuild {
    MiniPlan plan;
    std::int32_t radius = 0;
    std::vector<std::set<DiamondId>> levels;  // existing diamonds, by level; the last level's are leaves
    std::set<DiamondId> refined;
    std::map<DiamondId, Grid> reference_p;          // of every existing diamond
    std::map<DiamondId, RefinedHeights> reference;  // V and C of the refined ones
    std::map<DiamondId, Heights> p;                 // as a decoder must reconstruct them
    std::map<DiamondId, RefinedHeights> reconstructed;
    std::map<DiamondId, EncodedResiduals> residuals;
    std::map<Half, SummaryValues> summary;  // exact, before the file rounds it outwards
    std::vector<std::byte> bytes;           // the file

    std::shared_ptr<const Repository> open(const std::string& name = "mini.carat") const;
    bool has_half(const Half& half) const;
    // Every existing half whose diamond is not refined.
    std::vector<Half> leaves() const;
};

MiniBuild build_mini(const MiniPlan& plan);

// The index ranges of a half: visit(i, j).
template <class Visit>
void for_half(int n, int side, Visit visit) {
    for (int i = 0; i < n; ++i)
        for (int j = side == 0 ? 0 : i; j < (side == 0 ? i + 1 : n); ++j) visit(i, j);
}

}  // namespace carat::test
