// The passes over a build's diamonds. Each goes level by level, in steps of kStepDiamonds diamonds: the
// diamonds of a step are worked on in parallel, and what it leaves behind is a file of the store. A step
// whose file is there is skipped: that is how a build goes on.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "build_levels.hpp"
#include "build_progress.hpp"
#include "carat/codec/codec.hpp"
#include "carat/preprocess/build.hpp"
#include "heights_cache.hpp"
#include "step_store.hpp"

namespace carat {

struct BuildContext {
    const BuildOptions& options;
    const SourceStack& sources;
    const RefinedLevels& levels;
    double quantum;
    std::int32_t radius;
    ProgressReporter& progress;
    StepStore& store;
    std::size_t cache_bytes;  // for reconstructed heights

    int n() const { return (1 << options.log2_cells) + 1; }
    int depth() const { return static_cast<int>(levels.size()); }
    const std::vector<DiamondId>& ids(int level) const { return levels[static_cast<std::size_t>(level)]; }
    std::size_t steps(int level) const { return step_count(ids(level).size()); }
    // True if the store has a kind's files for all steps of a level.
    bool has_level(StepKind kind, int level) const;
};

// Errors at lattice points, metres.
struct ErrorSum {
    double max = 0, squares = 0;
    std::uint64_t count = 0;

    // Values whose |reconstructed - reference| are, in quanta, at most `worst`, with the given sum of
    // squares. The reference itself is within half a quantum of the source, taken as evenly spread in the sum
    // of squares.
    void add(std::int64_t worst, double sum_of_squares, std::size_t values, double quantum) {
        max = std::max(max, (static_cast<double>(worst) + 0.5) * quantum);
        squares += quantum * quantum * (sum_of_squares + static_cast<double>(values) / 12);
        count += values;
    }
    void add(const ErrorSum& other);
};

// Root values: reference heights of the six faces, N x N each.
using FaceHeights = std::array<std::vector<std::int32_t>, kFaces>;

// Source heights of a face, N x N, in quanta. Throws Error(limit) for heights beyond 2^30 quanta.
std::vector<std::int32_t> sample_face(const SourceStack& sources, double quantum, int n, int face);

// Reference of a refined diamond in mode 0, from the sources alone. Throws Error(limit) likewise.
void sample_reference(const SourceStack& sources, double quantum, int n, DiamondId d, RefinedHeights& out);

// Fine to coarse: source heights at the leaves, and up from there what each level is to be coded from. In
// mode 0 a coarser level takes every other sample, in modes 1 and 2 it is filtered. Every source block is
// read by the leaves of about one level, in the order of the space-filling curve. Throws Error(limit) for
// heights beyond 2^30 quanta.
FaceHeights make_reference(const BuildContext& context);

// What the summary of a half is made of.
struct HalfFacts {
    std::int32_t min = 0, max = 0;
    double flat = 0;  // flat_patch_bound, metres
};
// Of the half of a child, in the diamond that was coded.
struct ChildFacts {
    HalfFacts leaf;  // if the child is not refined
    std::array<std::int64_t, 6>
        deviation{};  // from the halves 1 to 6 levels up, 1/8 quanta; if refined, only of the sixth
};
struct DiamondFacts {
    std::array<HalfFacts, 2> own;
    std::array<ChildFacts, 4> child;  // child halves of side 0, then of side 1
    ErrorSum errors;
    std::uint64_t blob_bytes = 0;
    std::uint64_t blob_info = 0;  // BlobInfo::to_byte()
};

// Coarse to fine: codes every diamond. roots: reconstructed.
void code_levels(const BuildContext& context, const FaceHeights& roots);

// Fine to coarse: what the file needs to know of every diamond but its blob, by level, and the errors of all
// heights but the roots'.
struct Summaries {
    std::vector<DiamondEntry> diamonds;  // level by level
    ErrorSum errors;
    std::uint64_t blob_bytes = 0;
};
Summaries summarise_levels(const BuildContext& context);

}  // namespace carat
