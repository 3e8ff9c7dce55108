// The persistent cut: whatever came before, a converged frame is the converged cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

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
    for (const FakeRepository* planet : planets()) {
        Refiner refiner(borrow(*planet));
        for (const NamedView& v : test_views(*planet, 20, 5)) {
            const RefineGoal goal{2, 0};
            const RefinedFrame frame = refiner.frame(v.view, goal);
            EXPECT_TRUE(frame.converged);
            expect_same_meshes(frame.draw, converged_cut(*planet, v.view, goal.threshold).meshes, v.name);
            if (HasFatalFailure()) return;
        }
    }
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
