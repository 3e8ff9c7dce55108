// Virtual refinement leaves S as it is, to the last bit.
#include <gtest/gtest.h>

#include <random>

#include "carat/globe/patch.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

TEST(VirtualRefinement, HeightsLieExactlyOnTheLeafTriangles) {
    std::uint64_t tested = 0;
    int deepest = 0;
    for (const FakeRepository* repository : planets()) {
        const int cells = repository->header().cells();
        for (const NamedView& v : test_views(*repository, 20, 31)) {
            SCOPED_TRACE(v.name);
            const Cut cut = cut_of(*repository, v.view, 1.0);
            EXPECT_GE(cut.counters.refined, cut.counters.virtual_refined);
            for (const FrontierHalf& f : cut.frontier) {
                if (f.culled != Culled::none || !f.is_virtual) continue;
                deepest = std::max(deepest, f.half.diamond.level());
                const Half leaf = repository->leaf_above(f.half);
                ASSERT_NE(leaf, f.half);
                const HalfFrame frame = half_frame(f.half, cells);
                std::size_t k = 0;
                for (int r = 0; r <= cells; ++r)
                    for (int c = 0; c <= r; ++c, ++k, ++tested) {
                        const LatticePoint p = f.half.side == 0 ? frame.vertex(r, c) : frame.vertex(c, r);
                        ASSERT_EQ(static_cast<double>(f.heights.at(k)) * kHeightFraction,
                                  repository->surface(leaf, p))
                            << to_string(f.half.diamond);
                    }
            }
        }
    }
    EXPECT_GT(tested, 100000u);
    EXPECT_GE(deepest, 30);
}

// Down one path to the deepest level from the most awkward leaf: odd differences, every midpoint fractional.
TEST(VirtualRefinement, StaysExactToTheDeepestLevel) {
    const int cells = 4;
    Half half{root_diamond(0), 0};
    HalfHeights h0, h1;
    for (std::uint32_t k = 0; k < half_vertex_count(cells); ++k) h0.fine.push_back(0);
    for (int r = 0; r <= cells; ++r)
        for (int c = 0; c <= r; ++c)
            h0.fine[half_vertex_index(r, c)] = ((r * std::int64_t{5} + c * 3) * 268435399 % 2147483647)
                                               << kHeightFractionBits;
    h1 = h0;  // the same diagonal
    for (int level = 0; level < kDeepestId - 1; ++level) {
        const VirtualHeights refined = refine_virtually(h0, h1, cells);
        const Half child = child_halves(half)[static_cast<std::size_t>(level % 2)];
        // Both children halves of the child's diamond as if its other half were the mirror image.
        h0 = gather_child(refined, half.diamond, child);
        h1 = h0;
        half = child;
        for (std::uint32_t k = 0; k < h0.size(); ++k) {
            // After k levels there are at most ceil(k / 2) fractional bits.
            const std::int64_t unit = std::int64_t{1} << (kHeightFractionBits - (level + 2) / 2);
            ASSERT_EQ(h0.at(k) % unit, 0) << "level " << level + 1;
        }
    }
    EXPECT_EQ(half.diamond.level(), kDeepestId - 1);
}

TEST(VirtualRefinement, RangeIsTheGreatestOverTriangles) {
    // One spike: every triangle around it has the same range, its height.
    for (const int cells : {8, 64}) {
        HalfHeights whole, fine;
        whole.whole.assign(half_vertex_count(cells), 0);
        fine.fine.assign(half_vertex_count(cells), 0);
        whole.whole[half_vertex_index(5, 2)] = -77;
        fine.fine[half_vertex_index(5, 2)] = std::int64_t{-77} << kHeightFractionBits;
        for (const HalfHeights& heights : {whole, fine}) {
            const HalfRange range = half_range(heights, cells, 0.5);
            EXPECT_EQ(range.min, -38.5);
            EXPECT_EQ(range.max, 0);
            EXPECT_EQ(range.triangle_range, 38.5);
        }
        // A ramp of one a row: two corners of a triangle differ by one row at most.
        for (int r = 0; r <= cells; ++r)
            for (int c = 0; c <= r; ++c) {
                whole.whole[half_vertex_index(r, c)] = r;
                fine.fine[half_vertex_index(r, c)] = std::int64_t{r} << kHeightFractionBits;
            }
        EXPECT_EQ(half_range(whole, cells, 1).triangle_range, 1);
        EXPECT_EQ(half_range(fine, cells, 1).triangle_range, 1);
    }
}

// Whole heights go through vectors, fractions do not; extremes need all 32 bits.
TEST(VirtualRefinement, RangeOfWholeHeightsIsThatOfTheSameWithFractions) {
    std::mt19937_64 generator(5);
    std::uniform_int_distribution<std::int32_t> any(-(1 << 30), 1 << 30);
    for (int k = 0; k < 300; ++k) {
        const int cells = 4 << (k % 6);
        HalfHeights whole, fine;
        for (std::uint32_t v = 0; v < half_vertex_count(cells); ++v) {
            const std::int32_t h = any(generator) >> (k % 29);
            whole.whole.push_back(h);
            fine.fine.push_back(std::int64_t{h} << kHeightFractionBits);
        }
        const HalfRange w = half_range(whole, cells, 0.25), f = half_range(fine, cells, 0.25);
        ASSERT_EQ(w.min, f.min);
        ASSERT_EQ(w.max, f.max);
        ASSERT_EQ(w.triangle_range, f.triangle_range) << cells;
    }
}

}  // namespace
}  // namespace carat::test
