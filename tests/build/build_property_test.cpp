// Promises of the builder: the error bound at every lattice point, the same bytes for any thread count, true
// summaries, closure, and a depth that follows the data.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "carat/codec/repository.hpp"
#include "carat/codec/surface.hpp"
#include "carat/globe/bounds.hpp"
#include "carat/globe/error.hpp"
#include "scratch.hpp"

namespace carat::test {
namespace {

// Visits every half of the file's full-depth tree below a half; visit(half, leaf).
template <class Visit>
void walk(const Repository& repository, const Half& half, Visit visit) {
    const bool refined = repository.refined(half.diamond);
    visit(half, !refined);
    if (!refined) return;
    for (const Half& child : child_halves(half)) walk(repository, child, visit);
}

template <class Visit>
void walk_all(const Repository& repository, Visit visit) {
    for (int face = 0; face < kFaces; ++face)
        for (const int side : {0, 1}) walk(repository, {root_diamond(face), side}, visit);
}

template <class Visit>
void for_vertices(const Half& half, int n, Visit visit) {
    const HalfFrame frame = half_frame(half, n - 1);
    for (int i = 0; i < n; ++i)
        for (int j = half.side == 0 ? 0 : i; j < (half.side == 0 ? i + 1 : n); ++j)
            visit(i, j, frame.vertex(i, j));
}

class Modes : public testing::TestWithParam<Mode> {};

TEST_P(Modes, EveryLeafSampleIsWithinTheTolerance) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(synth::Kind::earth, scratch.folder, 256);
    options.mode = GetParam();
    const BuildReport report = build_repository(options);
    EXPECT_LE(report.max_error, options.tolerance);
    const auto repository = Repository::open(options.output);
    const Surface surface(repository);
    const SourceStack sources(options.layers, options.body, 0, std::size_t{64} << 20);
    double worst = 0;
    std::size_t samples = 0;
    walk_all(*repository, [&](const Half& half, bool leaf) {
        if (!leaf) return;
        const auto p = surface.heights(half.diamond);
        for_vertices(half, p->n, [&](int i, int j, const LatticePoint& at) {
            const double truth = height_at_point(sources, at);
            worst = std::max(worst, std::abs(p->at(i, j) * repository->header().quantum - truth));
            ++samples;
        });
    });
    EXPECT_LE(worst, options.tolerance);
    EXPECT_GT(worst, 0.5 * options.tolerance) << "the bound is used";
    EXPECT_GT(samples, std::size_t{100000});
}

struct Range {
    double min = 1e300, max = -1e300;

    void include(const Range& r) {
        min = std::min(min, r.min);
        max = std::max(max, r.max);
    }
};

// Compares the summaries of a half and of all below it with the heights themselves; returns the range found.
// How tight they are is tested in tests/codec: the summary of a zero page is one for all its area.
Range check_summaries(const Surface& surface, const Half& half) {
    const Repository& repository = surface.repository();
    const auto p = surface.heights(half.diamond);
    Range range;
    for_vertices(half, p->n, [&](int i, int j, const LatticePoint&) {
        const double h = p->at(i, j) * repository.header().quantum;
        range.include({h, h});
    });
    const HalfSummary summary = repository.summary(half);
    if (repository.refined(half.diamond))
        for (const Half& child : child_halves(half)) range.include(check_summaries(surface, child));
    EXPECT_LE(summary.min_height, range.min);
    EXPECT_GE(summary.max_height, range.max);
    EXPECT_GT(summary.delta, 0);
    return range;
}

TEST_P(Modes, SummariesHoldEveryDescendant) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(synth::Kind::earth, scratch.folder, 128);
    options.mode = GetParam();
    build_repository(options);
    const Surface surface(Repository::open(options.output));
    for (int face = 0; face < kFaces; ++face)
        for (const int side : {0, 1}) check_summaries(surface, {root_diamond(face), side});
}

INSTANTIATE_TEST_SUITE_P(All, Modes, testing::Values(Mode::interpolating, Mode::filtered, Mode::paper));

TEST(Build, DepthFollowsTheData) {
    const Scratch scratch;
    const BuildOptions options = synthetic_build(synth::Kind::earth, scratch.folder, 256);
    build_repository(options);
    const auto repository = Repository::open(options.output);
    const SourceStack sources(options.layers, options.body, 0, std::size_t{64} << 20);
    const int cells = repository->header().cells();
    std::size_t refined = 0;
    walk_all(*repository, [&](const Half& half, bool leaf) {
        if (leaf) {
            // A leaf is as fine as its data ask, over the part of the diamond that exists.
            EXPECT_LE(sample_spacing(options.body, half.diamond, cells),
                      1.0001 * sources.finest_spacing(half.diamond));
        } else {
            refined += half.side == 0 ? 1 : 0;
            for (const int side : {0, 1})
                if (const auto up = parent(half.diamond, side)) {
                    EXPECT_TRUE(repository->refined(*up));
                }
        }
    });
    EXPECT_EQ(refined, repository->header().refined_diamonds);
}

TEST(Build, ExistingOutputIsKeptUnlessOverwriting) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(synth::Kind::constant, scratch.folder);
    build_repository(options);
    const std::string before = bytes_of(options.output);
    options.tolerance = 20;
    EXPECT_THROW(build_repository(options), Error);
    EXPECT_TRUE(bytes_of(options.output) == before);
    options.overwrite = true;
    EXPECT_NO_THROW(build_repository(options));
}

TEST(Build, CancellingLeavesNothing) {
    const Scratch scratch;
    const BuildOptions options = synthetic_build(synth::Kind::earth, scratch.folder, 256);
    EXPECT_THROW(
        build_repository(options, [](const BuildProgress& p) { return p.stage != BuildStage::coding; }),
        Error);
    EXPECT_FALSE(std::filesystem::exists(options.output));
    EXPECT_FALSE(std::filesystem::exists(options.output.string() + ".partial"));
}

TEST(Build, PlanCountsWhatTheBuildMakes) {
    const Scratch scratch;
    const BuildOptions options = synthetic_build(synth::Kind::earth, scratch.folder, 256);
    const BuildPlan plan = plan_build(options);
    EXPECT_FALSE(std::filesystem::exists(options.output));
    const BuildReport report = build_repository(options);
    EXPECT_EQ(plan.refined, report.plan.refined);
    EXPECT_EQ(plan.refined, report.coded_diamonds + report.zero_diamonds);
    EXPECT_EQ(Repository::open(options.output)->header().refined_diamonds, plan.refined);
}

}  // namespace
}  // namespace carat::test
