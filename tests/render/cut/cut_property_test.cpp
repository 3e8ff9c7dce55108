// What makes a cut *the* cut: closed, conforming, within the threshold, least, and the same for every thread
// count.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <numbers>
#include <set>

#include "carat/globe/bounds.hpp"
#include "carat/globe/error.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/vertex_position.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

class CutTest : public testing::TestWithParam<double> {};  // threshold, pixels

bool contains(const Cut& cut, DiamondId d) {
    return std::binary_search(cut.refined.begin(), cut.refined.end(), d);
}

bool exists(const Cut& cut, const Half& half) {
    const auto above = parent(half.diamond, half.side);
    return !above || contains(cut, *above);
}

// Every planet, every view: check(repository, view, cut).
template <class Check>
void for_each_cut(double threshold, int random, Check check) {
    for (const FakeRepository* repository : planets())
        for (const NamedView& v : test_views(*repository, random, 11)) {
            SCOPED_TRACE(v.name + ", " + std::to_string(repository->header().n()) + " vertices a side");
            check(*repository, v.view, cut_of(*repository, v.view, threshold));
        }
}

TEST_P(CutTest, IsClosedAndItsFrontierIsComplete) {
    for_each_cut(GetParam(), 12, [](const FakeRepository&, const View&, const Cut& cut) {
        std::set<Half> frontier;
        for (const DiamondId d : cut.refined) {
            for (const int h : {0, 1}) {
                const auto above = parent(d, h);
                EXPECT_TRUE(!above || contains(cut, *above)) << to_string(d);
                for (const Half& k : child_halves({d, h}))
                    if (!contains(cut, k.diamond)) frontier.insert(k);
            }
        }
        for (int face = 0; face < kFaces; ++face)
            for (const int h : {0, 1})
                if (!contains(cut, root_diamond(face))) frontier.insert({root_diamond(face), h});
        std::set<Half> found;
        for (const FrontierHalf& f : cut.frontier) found.insert(f.half);
        EXPECT_EQ(found, frontier);
        EXPECT_EQ(found.size(), cut.frontier.size());
        EXPECT_TRUE(std::is_sorted(cut.frontier.begin(), cut.frontier.end(),
                                   [](const auto& l, const auto& r) { return l.half < r.half; }));
    });
}

TEST_P(CutTest, EveryEdgeIsSharedByExactlyTwoFrontierHalves) {
    for_each_cut(GetParam(), 12,
                 [](const FakeRepository&, const View&, const Cut& cut) { expect_conforming(cut); });
}

TEST_P(CutTest, NothingDrawnExceedsTheThreshold) {
    int checked = 0;
    for_each_cut(GetParam(), 12, [&](const FakeRepository&, const View&, const Cut& cut) {
        double worst = 0;
        std::uint64_t limited = 0;
        for (const FrontierHalf& f : cut.frontier) {
            if (f.culled != Culled::none) continue;
            worst = std::max(worst, f.error);
            if (f.error <= GetParam()) continue;
            ++limited;
            EXPECT_EQ(f.half.diamond.level(), kDeepestId) << to_string(f.half.diamond) << ' ' << f.error;
        }
        EXPECT_EQ(limited, cut.counters.limited);
        EXPECT_EQ(worst, cut.counters.worst_error);
        ++checked;
    });
    EXPECT_GT(checked, 100);
}

// The demand of a half, recomputed from the repository alone.
bool demands(const FakeRepository& repository, const Visibility& visibility, const Half& half,
             double threshold) {
    const RepositoryHeader& h = repository.header();
    const Ellipsoid& body = visibility.body();
    const double rounding = visibility.view().unit() * (std::numbers::sqrt3 / 2 + kPositionRounding);
    const auto exceeds = [&](double low, double high, double delta) {
        const HalfVolume volume = half_volume(body, half, low, high, rounding);
        return visibility.cull(volume) == Culled::none &&
               visibility.screen_error(volume, delta + rounding) > threshold;
    };
    const Half leaf = repository.leaf_above(half);
    if (leaf == half) {
        const HalfSummary s = repository.summary(half);
        if (!exceeds(s.min_height, s.max_height, s.delta)) return false;
        if (repository.refined(half.diamond)) return true;
    }
    const HalfFrame frame = half_frame(half, h.cells());
    HalfHeights heights;
    for (int r = 0; r <= h.cells(); ++r)
        for (int c = 0; c <= r; ++c) {
            const LatticePoint p = half.side == 0 ? frame.vertex(r, c) : frame.vertex(c, r);
            heights.fine.push_back(std::llround(repository.surface(leaf, p) / kHeightFraction));
        }
    const HalfRange range = half_range(heights, h.cells(), h.quantum);
    return exceeds(range.min, range.max, leaf_delta(body, half, range, h.cells()));
}

TEST_P(CutTest, IsTheLeast) {
    std::uint64_t forced = 0, refined = 0;
    for_each_cut(GetParam(), 4, [&](const FakeRepository& repository, const View& view, const Cut& cut) {
        const Visibility visibility = visibility_of(repository, view, GetParam());
        for (const DiamondId d : cut.refined) {
            const auto below = d.level() < kDeepestId ? children(d) : std::array<DiamondId, 4>{};
            const bool by_child =
                std::any_of(below.begin(), below.end(), [&](DiamondId k) { return contains(cut, k); });
            if (by_child) continue;
            const bool by_half =
                (exists(cut, {d, 0}) && demands(repository, visibility, {d, 0}, GetParam())) ||
                (exists(cut, {d, 1}) && demands(repository, visibility, {d, 1}, GetParam()));
            EXPECT_TRUE(by_half) << to_string(d) << " is refined for nothing";
        }
        for (const FrontierHalf& f : cut.frontier)
            if (f.half.diamond.level() < kDeepestId) {
                EXPECT_FALSE(demands(repository, visibility, f.half, GetParam()))
                    << to_string(f.half.diamond);
            }
        refined += cut.refined.size();
        forced +=
            static_cast<std::uint64_t>(std::count_if(cut.frontier.begin(), cut.frontier.end(),
                                                     [](const auto& f) { return f.culled != Culled::none; }));
    });
    EXPECT_GT(refined, 1000u);
    EXPECT_GT(forced, 1000u);
}

INSTANTIATE_TEST_SUITE_P(Thresholds, CutTest, testing::Values(0.7, 3.0, 20.0));

// With culling held fixed, a smaller threshold refines a superset.
TEST(Cut, IsMonotoneInTheThreshold) {
    for (const FakeRepository* repository : planets())
        for (const NamedView& v : test_views(*repository, 12, 5)) {
            SCOPED_TRACE(v.name);
            const Visibility visibility = visibility_of(*repository, v.view, 16);
            std::vector<DiamondId> coarser;
            for (const double threshold : {16.0, 5.0, 1.5}) {
                std::vector<DiamondId> refined = select_cut(*repository, visibility, threshold).refined;
                EXPECT_TRUE(std::includes(refined.begin(), refined.end(), coarser.begin(), coarser.end()));
                coarser = std::move(refined);
            }
        }
}

void expect_same(const DrawList& l, const DrawList& r) {
    ASSERT_EQ(l.meshes.size(), r.meshes.size());
    for (std::size_t k = 0; k < l.meshes.size(); ++k) {
        const PatchMesh &p = *l.meshes[k], &q = *r.meshes[k];
        ASSERT_EQ(p.half, q.half);
        ASSERT_EQ(p.anchor, q.anchor);
        ASSERT_EQ(p.vertices.size(), q.vertices.size());
        for (std::size_t v = 0; v < p.vertices.size(); ++v) {
            ASSERT_EQ(p.vertices[v].offset, q.vertices[v].offset);
            ASSERT_EQ(p.vertices[v].normal, q.vertices[v].normal);
            ASSERT_EQ(p.vertices[v].height, q.vertices[v].height);
        }
    }
    EXPECT_EQ(l.counters.halves_tested, r.counters.halves_tested);
    EXPECT_EQ(l.counters.culled_frustum, r.counters.culled_frustum);
    EXPECT_EQ(l.counters.culled_horizon, r.counters.culled_horizon);
    EXPECT_EQ(l.counters.refined, r.counters.refined);
    EXPECT_EQ(l.counters.worst_error, r.counters.worst_error);
}

TEST(Cut, DoesNotDependOnTheNumberOfThreads) {
    for (const FakeRepository* repository : planets())
        for (const NamedView& v : test_views(*repository, 6, 3)) {
            SCOPED_TRACE(v.name);
            DrawList lists[2];
            const int threads[] = {1, 4};
            const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
            for (const std::size_t k : {0u, 1u}) {
                tbb::task_arena arena(threads[k]);
                arena.execute([&] { lists[k] = converged_cut(*repository, v.view, 2.0); });
            }
            expect_same(lists[0], lists[1]);
        }
}

// With a spacing, the cut is finer, and no sample that the file could better lies further from the next on
// screen.
TEST(Cut, SpacingAsksForTheSamplesOfTheFile) {
    std::uint64_t finer = 0, tested = 0;
    for (const FakeRepository* repository : planets())
        for (const NamedView& v : test_views(*repository, 6, 21)) {
            SCOPED_TRACE(v.name);
            const Visibility visibility = visibility_of(*repository, v.view, 20);
            const Cut plain = select_cut(*repository, visibility, 20);
            const Cut cut = select_cut(*repository, visibility, 20, 6);
            EXPECT_TRUE(std::includes(cut.refined.begin(), cut.refined.end(), plain.refined.begin(),
                                      plain.refined.end()));
            finer += cut.refined.size() - plain.refined.size();
            for (const FrontierHalf& f : cut.frontier) {
                if (f.culled != Culled::none || !repository->refined(f.half.diamond)) continue;
                const int cells = repository->header().cells();
                const double spacing = sample_spacing(repository->body(), f.half.diamond, cells);
                for (const auto& [r, c] :
                     {std::pair{0, 0}, {cells, 0}, {cells, cells}, {cells / 2, cells / 4}}) {
                    const Vec3 p = repository->surface_point(
                        repository->leaf_at(f.half, lattice_vertex(f.half, cells, r, c)),
                        lattice_vertex(f.half, cells, r, c));
                    EXPECT_LE(v.view.focal_pixels() * spacing / norm(minus(p, v.view.eye())), 6 * (1 + 1e-9));
                    ++tested;
                }
            }
        }
    EXPECT_GT(finer, 100u);
    EXPECT_GT(tested, 100u);
}

TEST(Cut, CountersAddUp) {
    for (const FakeRepository* repository : planets())
        for (const NamedView& v : test_views(*repository, 6, 3)) {
            SCOPED_TRACE(v.name);
            const DrawList list = converged_cut(*repository, v.view, 2.0);
            const CutCounters& c = list.counters;
            EXPECT_EQ(c.patches, list.meshes.size());
            EXPECT_EQ(c.triangles, c.patches * static_cast<std::uint64_t>(repository->header().cells()) *
                                       static_cast<std::uint64_t>(repository->header().cells()));
            EXPECT_EQ(c.refined, c.decoded + c.virtual_refined);
            EXPECT_LE(c.culled_frustum + c.culled_horizon + c.patches, c.halves_tested);
        }
}

// A threshold that would fill any memory ends in an error, not in a crash.
TEST(Cut, StopsAtItsLimit) {
    ViewRequest request;
    request.height = 1e4;
    try {
        converged_cut(plain_mars(), View(Ellipsoid::mars(), request), 1e-7);
        FAIL() << "no error";
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::limit);
    }
}

TEST(Cut, RefusesAThresholdThatNothingMeets) {
    const View view(Ellipsoid::earth(), ViewRequest{});
    EXPECT_THROW(converged_cut(rough_earth(), view, 0), Error);
    EXPECT_THROW(converged_cut(rough_earth(), view, -1), Error);
    EXPECT_THROW(converged_cut(rough_earth(), view, 1, -1), Error);
    EXPECT_THROW(converged_cut(plain_mars(), view, 1), Error) << "a view of another body";
}

}  // namespace
}  // namespace carat::test
