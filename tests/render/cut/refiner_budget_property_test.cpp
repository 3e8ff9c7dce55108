// Budgets of memory, triangles and uploads: kept by every frame, and no work is done twice for their sake.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <random>

#include "carat/globe/patch.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/refiner.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

std::shared_ptr<const Repository> borrow(const FakeRepository& repository) {
    return {std::shared_ptr<const void>(), &repository};
}

std::uint64_t triangles_of_a_patch(const FakeRepository& planet) {
    const auto cells = static_cast<std::uint64_t>(planet.header().cells());
    return cells * cells;
}
std::uint64_t bytes_of_a_mesh(const FakeRepository& planet) {
    return half_vertex_count(planet.header().cells()) * sizeof(PatchVertex);
}

struct Limits {
    std::uint64_t patches, bytes;
};
constexpr std::uint64_t kAny = 1'000'000, kMuch = std::uint64_t{1} << 30;
constexpr Limits kLimits[] = {
    {60, kMuch}, {200, kMuch}, {kAny, 500'000}, {kAny, 1'500'000}, {150, 1'000'000}};

RefinerOptions options_of(const Limits& limits, const FakeRepository& planet) {
    RefinerOptions options;
    options.triangles = limits.patches * triangles_of_a_patch(planet);
    options.bytes = limits.bytes;
    return options;
}

RefineBudget milliseconds(double ms) {
    RefineBudget budget;
    budget.milliseconds = ms;
    return budget;
}

bool at_rest(const RefineCounters& c) {
    return c.built == 0 && c.decoded == 0 && c.predicted == 0 && c.virtual_decoded == 0 && c.installed == 0 &&
           c.coarsened == 0 && c.unstitched == 0;
}

// Frames with a time limit, after another view, come to rest where a frame without one does.
TEST(RefinerBudget, AStillViewComesToRestAtTheErrorOfFramesWithoutTimeLimit) {
    using Clock = std::chrono::steady_clock;
    constexpr RefineGoal goal{0.3, 0};
    constexpr int kRest = 20;  // frames, more than what is no longer needed is kept for
    std::uint64_t full = 0;
    for (const FakeRepository* planet : {&rough_earth(), &plain_mars()})
        for (const Limits& limits : kLimits) {
            Refiner refiner(borrow(*planet), options_of(limits, *planet));
            const std::vector<NamedView> views = test_views(*planet, 6, 31);
            for (std::size_t k = 0; k < views.size(); k += 4) {
                const NamedView& v = views[k];
                Refiner untimed(borrow(*planet), options_of(limits, *planet));
                RefinedFrame wanted;
                for (int again = 0; again < 3; ++again) wanted = untimed.frame(v.view, goal);
                int frames = 0, rest = 0;
                RefinedFrame frame;
                // Workers may not get to spare meshes for some time if others have all cores.
                const auto give_up = Clock::now() + std::chrono::seconds(20);
                for (; rest < kRest && (frames < 1000 || Clock::now() < give_up); ++frames) {
                    frame = refiner.frame(v.view, goal, milliseconds(2));
                    rest = at_rest(frame.counters) ? rest + 1 : 0;
                }
                EXPECT_EQ(rest, kRest)
                    << v.name << ", " << limits.patches << " patches, " << limits.bytes
                    << " bytes: still at work after " << frames << " frames: " << frame.counters.built
                    << " built, " << frame.counters.decoded << " decoded, " << frame.counters.installed
                    << " installed, " << frame.counters.coarsened << " coarsened, "
                    << frame.counters.unstitched << " borders open";
                EXPECT_LE(frame.counters.worst_error, 1.1 * wanted.counters.worst_error)
                    << v.name << ", " << limits.patches << " patches, " << limits.bytes << " bytes";
                full += frame.converged ? 0 : 1;
            }
        }
    EXPECT_GT(full, 10u);
}

// Turns and jumps bring into sight what was not, and every frame is cut short somewhere.
TEST(RefinerBudget, EveryFrameWithATimeLimitKeepsThem) {
    const FakeRepository& planet = rough_earth();
    const std::uint64_t mesh = bytes_of_a_mesh(planet), triangles = triangles_of_a_patch(planet);
    // Of uploads, what makes for some progress: one refinement, or the coarser patches for halves without
    // mesh, and the copies of one seam.
    const std::uint64_t progress = (4 + 8) * mesh;
    std::mt19937_64 generator(5);
    std::uniform_real_distribution<double> exponent(-1, 0.5);
    std::uint64_t full = 0, coarsened = 0;
    for (const Limits& limits : kLimits) {
        const RefinerOptions options = options_of(limits, planet);
        Refiner refiner(borrow(planet), options);
        for (const NamedView& v : test_views(planet, 15, 41))
            for (int turn = 0; turn < 8; ++turn) {
                ViewRequest request = v.request;
                request.heading += 25 * turn;
                RefineBudget budget = milliseconds(std::pow(10.0, exponent(generator)));
                budget.upload_bytes = 24 * mesh;
                const RefinedFrame frame = refiner.frame(View(planet.body(), request), {0.5, 0}, budget);
                const RefineCounters& c = frame.counters;
                const std::string what = v.name + ", turn " + std::to_string(turn);
                EXPECT_LE(c.triangles, options.triangles) << what;
                EXPECT_EQ(c.triangles, frame.draw.size() * triangles);
                EXPECT_LE(c.bytes, options.bytes) << what;
                EXPECT_LE(c.upload_bytes, budget.upload_bytes + progress) << what;
                full += frame.converged ? 0 : 1;
                coarsened += c.coarsened;
                if (turn == 7)
                    expect_watertight({frame.draw, {}}, planet.header().cells(), c.unstitched == 0);
            }
    }
    EXPECT_GT(full, 200u);
    EXPECT_GT(coarsened, 300u);
}

// A turn brings halves without meshes into sight among others that are refined further: it is sooner to build
// a few than to coarsen all around them, however short the frame.
TEST(RefinerBudget, AMeshThatIsMissingDoesNotCostTheCutAroundIt) {
    const FakeRepository& planet = rough_earth();
    std::uint64_t coarsened = 0, turns = 0;
    for (const NamedView& v : test_views(planet, 4, 51)) {
        Refiner refiner(borrow(planet));
        RefinedFrame frame;
        for (int k = 0; k < 500 && !frame.converged; ++k)
            frame = refiner.frame(v.view, {0.5, 0}, milliseconds(2));
        ASSERT_TRUE(frame.converged) << v.name;
        // What is not needed any more is kept for so many frames.
        for (int turn = 1; turn < 8; ++turn, ++turns) {
            ViewRequest request = v.request;
            request.heading += 15 * turn;
            frame = refiner.frame(View(planet.body(), request), {0.5, 0}, milliseconds(0.2));
            coarsened += frame.counters.coarsened;
        }
    }
    EXPECT_LT(coarsened, 2 * turns);  // 3 a turn if halves always give way
}

// What is no longer needed goes least error first. A small budget of uploads spreads it over frames: what
// appears in one has no greater error than what appears in the next, but for patches that had to wait for
// finer ones.
TEST(RefinerBudget, TheLeastErrorIsCoarsenedFirst) {
    const FakeRepository& planet = rough_earth();
    std::uint64_t in_order = 0, out_of_order = 0;
    for (const NamedView& v : test_views(planet, 0, 61)) {
        // From near the ground much waits: patches of little error hold finer ones of more.
        if (!v.name.starts_with("oblique")) continue;
        Refiner refiner(borrow(planet));
        RefineBudget budget;
        budget.upload_bytes = kMuch;  // limited, so that steps on the way have meshes
        RefinedFrame frame = refiner.frame(v.view, {0.2, 0}, budget);
        std::map<Half, int> before, appeared;
        for (const auto& mesh : frame.draw) before[mesh->half] = 0;
        budget.upload_bytes = 6 * bytes_of_a_mesh(planet);
        int frames = 0;
        for (; frames < 500 && (frames == 0 || !frame.converged); ++frames) {
            frame = refiner.frame(v.view, {1, 0}, budget);
            for (const auto& mesh : frame.draw)
                if (!before.contains(mesh->half)) appeared.try_emplace(mesh->half, frames);
        }
        EXPECT_TRUE(frame.converged) << v.name;
        // Of the patches there at last: of a diamond's two halves the greater error counts.
        const DrawList last = converged_cut(planet, v.view, 1);
        std::map<DiamondId, std::pair<int, double>> coarsened;
        for (std::size_t k = 0; k < last.meshes.size(); ++k) {
            const auto at = appeared.find(last.meshes[k]->half);
            if (at == appeared.end()) continue;
            auto& [when, error] = coarsened[at->first.diamond];
            when = at->second;
            error = std::max(error, last.facts[k].error);
        }
        for (const auto& [a, first] : coarsened)
            for (const auto& [b, second] : coarsened)
                if (first.first < second.first) ++(first.second <= second.second ? in_order : out_of_order);
    }
    EXPECT_GT(in_order, 300u);
    EXPECT_LT(out_of_order, in_order / 8) << in_order;
}

}  // namespace
}  // namespace carat::test
