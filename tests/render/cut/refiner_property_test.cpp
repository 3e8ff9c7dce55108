// The persistent cut: whatever came before, a converged frame is the converged cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>

#include "carat/globe/patch.hpp"
#include "carat/render/refiner.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

// A repository that outlives the test.
std::shared_ptr<const Repository> borrow(const FakeRepository& repository) {
    return {std::shared_ptr<const void>(), &repository};
}

void expect_same_meshes(const std::vector<std::shared_ptr<const PatchMesh>>& drawn,
                        const std::vector<std::shared_ptr<const PatchMesh>>& wanted,
                        const std::string& what) {
    ASSERT_EQ(drawn.size(), wanted.size()) << what;
    for (std::size_t k = 0; k < drawn.size(); ++k) {
        const PatchMesh &d = *drawn[k], &w = *wanted[k];
        ASSERT_EQ(d.half, w.half) << what;
        ASSERT_EQ(d.anchor, w.anchor) << what;
        ASSERT_EQ(d.vertices.size(), w.vertices.size()) << what;
        for (std::size_t v = 0; v < d.vertices.size(); ++v) {
            ASSERT_EQ(d.vertices[v].offset, w.vertices[v].offset) << what;
            ASSERT_EQ(d.vertices[v].normal, w.vertices[v].normal) << what << ", vertex " << v;
            ASSERT_EQ(d.vertices[v].height, w.vertices[v].height) << what;
        }
    }
}

TEST(RefinerProperty, ConvergesToTheConvergedCutWhateverCameBefore) {
    for (const FakeRepository* planet : planets())
        for (const int threads : {1, 3}) {
            RefinerOptions options;
            options.threads = threads;
            Refiner refiner(borrow(*planet), options);
            for (const NamedView& v : test_views(*planet, 10, 5)) {
                const RefineGoal goal{2, 0};
                const RefinedFrame frame = refiner.frame(v.view, goal);
                EXPECT_TRUE(frame.converged);
                const DrawList wanted = converged_cut(*planet, v.view, goal.threshold);
                expect_same_meshes(frame.draw, wanted.meshes, v.name);
                EXPECT_EQ(frame.counters.refined, wanted.counters.refined);
                EXPECT_EQ(frame.counters.virtual_refined, wanted.counters.virtual_refined);
                EXPECT_EQ(frame.counters.triangles, wanted.counters.triangles);
                EXPECT_EQ(frame.counters.limited, wanted.counters.limited);
                EXPECT_EQ(frame.counters.worst_error, wanted.counters.worst_error);
                if (HasFatalFailure()) return;
            }
        }
}

// Jumps between views, each shown for a few frames that are cut short anywhere.
TEST(RefinerProperty, FramesCutShortAreWatertightWithoutHoles) {
    std::mt19937_64 generator(7);
    std::uniform_real_distribution<double> exponent(-1.5, 1);
    std::uint64_t unfinished = 0, shared = 0, rays = 0;
    for (const FakeRepository* planet : planets()) {
        const int cells = planet->header().cells();
        // The flat cells of the faces, 22 degrees wide at the coarsest, lie below the body by up to a tenth.
        constexpr double scale = 0.9;
        Refiner refiner(borrow(*planet));
        for (const NamedView& v : test_views(*planet, 20, 8))
            for (int k = 0; k < 4; ++k) {
                RefineBudget budget;
                budget.milliseconds = std::pow(10.0, exponent(generator));
                const RefinedFrame frame = refiner.frame(v.view, {1, 0}, budget);
                unfinished += frame.converged ? 0 : 1;
                const DrawList list{frame.draw, {}};
                shared += expect_watertight(list, cells, frame.counters.unstitched == 0);
                rays += expect_no_hole(planet->body(), scale, v.view, list, cells, generator);
                if (HasFailure()) return;
            }
    }
    EXPECT_GT(unfinished, 50u);
    EXPECT_GT(shared, 10'000u);
    EXPECT_GT(rays, 1'000u);
}

TEST(RefinerProperty, ShortFramesOfOneViewArriveAtTheConvergedCut) {
    const FakeRepository& planet = rough_earth();
    Refiner refiner(borrow(planet));
    RefineBudget budget;
    budget.milliseconds = 1;
    for (const NamedView& v : test_views(planet, 5, 9)) {
        RefinedFrame frame;
        for (int k = 0; k < 2000 && !frame.converged; ++k) frame = refiner.frame(v.view, {2, 0}, budget);
        EXPECT_TRUE(frame.converged) << v.name;
        expect_same_meshes(frame.draw, converged_cut(planet, v.view, 2).meshes, v.name);
        if (HasFatalFailure()) return;
    }
}

TEST(RefinerProperty, BudgetsOfTrianglesMemoryAndUploadsHold) {
    const FakeRepository& planet = rough_earth();
    const int cells = planet.header().cells();
    const std::uint64_t a_patch = static_cast<std::uint64_t>(cells) * static_cast<std::uint64_t>(cells);
    RefinerOptions options;
    options.triangles = 60 * a_patch;
    options.bytes = 1'500'000;
    Refiner refiner(borrow(planet), options);
    std::uint64_t full = 0;
    for (const NamedView& v : test_views(planet, 20, 10))
        for (int k = 0; k < 3; ++k) {
            const RefinedFrame frame = refiner.frame(v.view, {0.5, 0});
            EXPECT_LE(frame.counters.triangles, options.triangles) << v.name;
            EXPECT_LE(frame.counters.bytes, options.bytes) << v.name;
            EXPECT_EQ(frame.counters.triangles, frame.draw.size() * a_patch);
            expect_watertight({frame.draw, {}}, cells, frame.counters.unstitched == 0);
            full += frame.converged ? 0 : 1;
        }
    EXPECT_GT(full, 20u);

    // Uploads: a change of view makes a few necessary, the budget the rest.
    Refiner slow(borrow(planet));
    RefineBudget budget;
    const std::uint64_t mesh_bytes = half_vertex_count(cells) * sizeof(PatchVertex);
    budget.upload_bytes = 8 * mesh_bytes;
    const std::vector<NamedView> views = test_views(planet, 20, 11);
    const auto drawn = [&](const NamedView& v) { return converged_cut(planet, v.view, 1).meshes.size(); };
    const View& view =
        std::max_element(views.begin(), views.end(), [&](const NamedView& l, const NamedView& r) {
            return drawn(l) < drawn(r);
        })->view;
    (void)slow.frame(views.front().view, {1e9, 0});
    RefinedFrame frame;
    int frames = 0;
    for (; frames < 2000 && !frame.converged; ++frames) {
        frame = slow.frame(view, {1, 0}, budget);
        // Copies of neighbours with new border normals may exceed it by those of one seam.
        EXPECT_LE(frame.counters.upload_bytes, budget.upload_bytes + 8 * mesh_bytes);
    }
    EXPECT_TRUE(frame.converged);
    EXPECT_GT(frames, 5);
    expect_same_meshes(frame.draw, converged_cut(planet, view, 1).meshes, "after small uploads");
}

// With culling off the culled are decoded, built and drawn too, and no ray of the screen meets them first:
// the picture is the same. What is in sight keeps its meshes to the last bit. With it on, the work is
// strictly less.
TEST(RefinerProperty, WhatIsSkippedIsNotInThePicture) {
    std::mt19937_64 generator(23);
    std::uint64_t rays = 0, frustum = 0, horizon = 0, built_least = 0, built_all = 0, decoded_least = 0,
                  decoded_all = 0;
    for (const FakeRepository* planet : planets())
        for (const NamedView& v : test_views(*planet, 10, 24)) {
            Refiner skipping(borrow(*planet));
            const RefinedFrame least = skipping.frame(v.view, {2, 0});
            for (const bool of_frustum : {true, false}) {
                RefinerOptions options;
                (of_frustum ? options.skip_frustum : options.skip_horizon) = false;
                Refiner refiner(borrow(*planet), options);
                const RefinedFrame all = refiner.frame(v.view, {2, 0});
                EXPECT_EQ(all.counters.refined, least.counters.refined);
                EXPECT_EQ(least.counters.decoded + least.counters.virtual_decoded, least.counters.refined);
                std::vector<std::shared_ptr<const PatchMesh>> common, extra;
                for (const auto& mesh : all.draw) {
                    const bool in_sight = std::any_of(least.draw.begin(), least.draw.end(),
                                                      [&](const auto& m) { return m->half == mesh->half; });
                    (in_sight ? common : extra).push_back(mesh);
                }
                expect_same_meshes(common, least.draw, v.name);
                const std::uint64_t culled =
                    of_frustum ? least.counters.culled_frustum : least.counters.culled_horizon;
                EXPECT_EQ(extra.size(), culled) << v.name;
                if (culled > 0) {
                    EXPECT_LT(least.counters.triangles, all.counters.triangles);
                    EXPECT_LT(least.counters.upload_bytes, all.counters.upload_bytes);
                    EXPECT_LE(least.counters.decoded + least.counters.virtual_decoded,
                              all.counters.decoded + all.counters.virtual_decoded)
                        << v.name;
                }
                (of_frustum ? frustum : horizon) += culled;
                built_least += least.counters.built;
                built_all += all.counters.built;
                decoded_least += least.counters.decoded;
                decoded_all += all.counters.decoded;
                rays +=
                    expect_behind({least.draw, {}}, {extra, {}}, v.view, planet->header().cells(), generator);
                if (HasFailure()) return;
            }
        }
    EXPECT_GT(frustum, 100u);
    EXPECT_GT(horizon, 100u);
    EXPECT_LT(built_least, built_all);
    EXPECT_LT(decoded_least, decoded_all);
    EXPECT_GT(rays, 1000u);
}

TEST(RefinerProperty, UploadsAreWhatTheLastFrameDidNotDraw) {
    const FakeRepository& planet = rough_earth();
    Refiner refiner(borrow(planet));
    std::set<std::shared_ptr<const PatchMesh>> resident;
    for (const NamedView& v : test_views(planet, 10, 6)) {
        const RefinedFrame frame = refiner.frame(v.view, {2, 0});
        std::set<std::shared_ptr<const PatchMesh>> drawn(frame.draw.begin(), frame.draw.end()), wanted;
        std::set_difference(drawn.begin(), drawn.end(), resident.begin(), resident.end(),
                            std::inserter(wanted, wanted.end()));
        EXPECT_EQ(wanted,
                  (std::set<std::shared_ptr<const PatchMesh>>(frame.upload.begin(), frame.upload.end())))
            << v.name;
        resident = std::move(drawn);
    }
}

}  // namespace
}  // namespace carat::test
