// The passes over a build's diamonds.
#pragma once

#include "build_progress.hpp"
#include "build_tree.hpp"

namespace carat {

struct BuildContext {
    const BuildOptions& options;
    const SourceStack& sources;
    double quantum;
    std::int32_t radius;
    ProgressReporter& progress;

    int n() const { return (1 << options.log2_cells) + 1; }
};

// Errors at lattice points, metres.
struct ErrorSum {
    double max = 0, squares = 0;
    std::uint64_t count = 0;

    void add(double error);
    void add(const ErrorSum& other);
};

// Source height at lattice points, in quanta, rounded to nearest; error, if given, receives each point's
// rounding in metres (source - quanta * q). Throws Error(limit) beyond 2^30 quanta.
std::vector<std::int32_t> sample_points(const BuildContext& context, std::span<const LatticePoint> points,
                                        std::vector<double>* rounding);

// Root values: source (mode 0) or the filtered reference (modes 1, 2).
using FaceHeights = std::array<std::vector<std::int32_t>, kFaces>;
FaceHeights sample_roots(const BuildContext& context);
// Fine to coarse: reference V and C of every diamond, and the reference roots. Modes 1 and 2.
FaceHeights filter_tree(const BuildContext& context, BuildTree& tree);
// Coarse to fine: codes every diamond. Returns the errors at the lattice points coded (mode 0: exact; modes 1
// and 2: against the level's reference, half a quantum added).
ErrorSum code_tree(const BuildContext& context, const FaceHeights& roots, BuildTree& tree);
// Fine to coarse: min, max and delta of every half.
void summarise_tree(const BuildContext& context, BuildTree& tree);

}  // namespace carat
