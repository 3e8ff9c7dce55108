// Errors measured among all samples keep the threshold; the cut of one who knows them is no larger than ours.
#include <gtest/gtest.h>

#include <algorithm>

#include "carat/bench/triangles.hpp"
#include "carat/globe/patch.hpp"
#include "part_distances.hpp"
#include "render/cut/planets.hpp"

namespace carat::bench {
namespace {

std::shared_ptr<const Repository> borrow(const test::FakeRepository& repository) {
    return {std::shared_ptr<const void>(), &repository};
}

TEST(Triangles, TheOracleNeedsNoMoreAndNothingIsWorseThanTheThreshold) {
    TrianglesOptions o;
    o.views = 8;
    o.threshold = 8;
    o.width = 320;
    o.height = 200;
    std::uint64_t ours = 0, exact = 0, exact_delta = 0, quarters = 0;
    double greatest = 0;
    for (const test::FakeRepository* planet : {&test::rough_earth(), &test::smooth_ball()}) {
        const auto rows = measure_triangles(borrow(*planet), o);
        ASSERT_EQ(rows.size(), 8u);
        for (const TrianglesRow& r : rows) {
            SCOPED_TRACE(r.view);
            EXPECT_LE(r.error, o.threshold + 1e-6);
            greatest = std::max(greatest, r.error);
            ours += r.ours;
            exact += r.distance;
            exact_delta += r.exact_delta;
            quarters += r.exact_quarters;
        }
    }
    EXPECT_GT(greatest, 0.05 * o.threshold);
    // Of a view it may draw more: coarser halves are less often culled.
    EXPECT_LT(exact, quarters);
    EXPECT_LE(quarters, exact_delta);
    EXPECT_LE(exact_delta, ours);
    EXPECT_GT(exact, 0u);
    const auto share = [&](std::uint64_t triangles) {
        return static_cast<double>(triangles) / static_cast<double>(ours);
    };
    std::printf("of ours: exact distances %.3f, of quarters %.3f, oracle %.3f; greatest error %.2f px\n",
                share(exact_delta), share(quarters), share(exact), greatest);
}

// Of each quarter no more than the stored bound of the whole says, and somewhere nearly as much; found
// differently, by the surface's own points beneath a quarter, some are as far away as said and none is
// farther.
TEST(PartDistances, AreThoseOfTheFarthestPointsBelowEachQuarter) {
    const test::FakeRepository& planet = test::rough_earth();
    const auto file = borrow(planet);
    HalfPositions positions(file);
    PartDistances distances(*file, positions);
    const int cells = planet.header().cells();
    const double rounding = 1e-6;  // metres, of positions in double precision
    int unlike = 0, halves = 0, compared = 0;
    double tightest = 0;
    std::vector<Half> open;
    for (int face = 0; face < kFaces; ++face)
        for (const int side : {0, 1}) open.push_back({root_diamond(face), side});
    for (std::size_t k = 0; k < open.size() && halves < 300; ++k) {
        const Half half = open[k];
        if (!planet.refined(half.diamond)) continue;
        for (const Half& child : child_halves(half)) open.push_back(child);
        const QuarterDistances found = distances(half);
        ++halves;
        const double delta = planet.summary(half).delta;
        for (const double d : found) EXPECT_LE(d, delta + rounding);
        tightest = std::max(tightest, *std::max_element(found.begin(), found.end()) / delta);
        unlike += *std::min_element(found.begin(), found.end()) <
                  0.9 * *std::max_element(found.begin(), found.end());
        // The points of two grandchildren are the surface's own if these are leaves: not farther either.
        const auto vertices = positions(half);
        const FlatPatch flat(half, *vertices, cells);
        std::size_t quarter = 0;
        for (const Half& child : child_halves(half))
            for (const Half& part : child_halves(child)) {
                const bool leaf = planet.refined(child.diamond) && !planet.refined(part.diamond);
                double greatest = 0;
                const FlatPatch::Within at(flat, part);
                for (int r = 0; leaf && r <= cells; ++r)
                    for (int c = 0; c <= r; ++c) {
                        const HalfFrame f = half_frame(part, cells);
                        const LatticePoint p = part.side == 0 ? f.vertex(r, c) : f.vertex(c, r);
                        greatest =
                            std::max(greatest, length(subtract(at.at(r, c), planet.surface_point(part, p))));
                    }
                if (leaf) {
                    EXPECT_NEAR(found[quarter], greatest, rounding);
                    ++compared;
                }
                ++quarter;
            }
    }
    EXPECT_EQ(halves, 300);
    EXPECT_GT(compared, 300);
    EXPECT_GT(tightest, 0.9);
    EXPECT_GT(unlike, halves / 5);
}

// A view makes the same row whenever it is asked for.
TEST(Triangles, SameViewsSameRows) {
    TrianglesOptions o;
    o.views = 3;
    o.threshold = 4;
    const auto once = measure_triangles(borrow(test::smooth_ball()), o),
               again = measure_triangles(borrow(test::smooth_ball()), o);
    ASSERT_EQ(once.size(), again.size());
    for (std::size_t k = 0; k < once.size(); ++k) {
        EXPECT_EQ(once[k].ours, again[k].ours);
        EXPECT_EQ(once[k].distance, again[k].distance);
        EXPECT_EQ(once[k].error, again[k].error);
    }
}

}  // namespace
}  // namespace carat::bench
