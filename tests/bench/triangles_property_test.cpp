// Errors measured among all samples keep the threshold; the cut of one who knows them is no larger than ours.
#include <gtest/gtest.h>

#include "carat/bench/triangles.hpp"
#include "render/cut/planets.hpp"

namespace carat::bench {
namespace {

std::shared_ptr<const Repository> borrow(const test::FakeRepository& repository) {
    return {std::shared_ptr<const void>(), &repository};
}

TEST(Triangles, TheOracleNeedsNoMoreAndNothingIsWorseThanTheThreshold) {
    TrianglesOptions o;
    o.views = 8;
    o.threshold = 4;
    o.width = 320;
    o.height = 200;
    std::uint64_t ours = 0, exact = 0;
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
        }
    }
    EXPECT_GT(greatest, 0.1 * o.threshold);
    // Of a view it may draw more: coarser halves are less often culled.
    EXPECT_LE(exact, ours);
    EXPECT_GT(exact, 0u);
    std::printf("ours %.2f times the oracle's; greatest error %.2f px\n",
                static_cast<double>(ours) / static_cast<double>(exact), greatest);
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
