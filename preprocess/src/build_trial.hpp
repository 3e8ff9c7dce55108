// One diamond coded from source heights alone, before its parents are: for estimates, and for choices that a
// whole file shares. Its vertices are rounded as a quantiser would.
#pragma once

#include "build_levels.hpp"
#include "carat/codec/diamond_codec.hpp"
#include "carat/preprocess/build.hpp"

namespace carat {

// At most `most` of all refined diamonds, evenly spread over the list of all, coarse to fine.
std::vector<DiamondId> spread_diamonds(const RefinedLevels& levels, std::size_t most);

// Not thread-safe; one per thread or diamond.
class Trial {
  public:
    // options: quantum, tolerance (where there is no quantum), mode and cells count.
    Trial(const BuildOptions& options, const SourceStack& sources);

    // Reads the source heights of a diamond's vertices and cell centres. Throws what reading them throws.
    void take(DiamondId d);

    struct Result {
        std::size_t bytes = 0;
        double squares = 0;        // of reconstructed - reference, quanta
        std::uint64_t values = 0;  // that residuals were coded for
    };
    // Codes what was taken last. statistics, if not null, counts the range coder's tokens.
    Result code(const Coding& coding, std::int32_t radius, RangeStatistics* statistics);

  private:
    void take_half(const Half& half, DiamondId d);

    const BuildOptions& options_;
    const SourceStack& sources_;
    int n_;
    double quantum_;
    RefinedHeights reference_;
};

}  // namespace carat
