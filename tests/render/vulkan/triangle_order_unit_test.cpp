// The order of a patch's triangles: the same triangles, and few vertices shaded twice.
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>

#include "carat/globe/patch.hpp"
#include "triangle_order.hpp"

namespace carat {
namespace {

using Indices = std::vector<std::uint16_t>;

Indices unordered(int side, int cells) {
    Indices out;
    for (const auto& t : half_triangles(side, cells)) out.insert(out.end(), t.begin(), t.end());
    return out;
}
Indices of_side(const Indices& both, int side) {
    const auto half = static_cast<std::ptrdiff_t>(both.size() / 2);
    return side == 0 ? Indices(both.begin(), both.begin() + half) : Indices(both.begin() + half, both.end());
}
// Each turned so that the least index comes first, sorted.
std::vector<std::array<std::uint16_t, 3>> triangles(const Indices& indices) {
    std::vector<std::array<std::uint16_t, 3>> out;
    for (std::size_t k = 0; k < indices.size(); k += 3) {
        std::array<std::uint16_t, 3> t{indices[k], indices[k + 1], indices[k + 2]};
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        out.push_back(t);
    }
    std::sort(out.begin(), out.end());
    return out;
}
// Vertices shaded a triangle, with a FIFO of that many vertices; 0.5 is the least that a large grid allows.
double misses(const Indices& indices, int cells, unsigned cache) {
    return static_cast<double>(
        meshopt_analyzeVertexCache(indices.data(), indices.size(), half_vertex_count(cells), cache, 0, 0)
            .acmr);
}

TEST(TriangleOrder, IsOfTheSameTriangles) {
    for (const int cells : {2, 16, 64, 128}) {
        const Indices drawn = drawn_indices(cells);
        ASSERT_EQ(drawn.size(), static_cast<std::size_t>(6 * cells * cells));
        for (const int side : {0, 1})
            EXPECT_EQ(triangles(of_side(drawn, side)), triangles(unordered(side, cells))) << cells;
    }
}

// By meshoptimizer's own analyser. In rows each vertex of a wide patch is shaded for both rows that it joins:
// once a triangle. (Rows of 16 cells fit a cache of 32, where no order gains.)
TEST(TriangleOrder, SuitsTheVertexCache) {
    for (const int cells : {16, 64, 128})
        for (const int side : {0, 1})
            for (const unsigned cache : {16u, 32u}) {
                const double ordered = misses(of_side(drawn_indices(cells), side), cells, cache),
                             rows = misses(unordered(side, cells), cells, cache);
                std::printf("%d cells, side %d, cache of %u: %.3f vertices a triangle, in rows %.3f\n", cells,
                            side, cache, ordered, rows);
                EXPECT_GT(ordered, 0.5);
                EXPECT_LT(ordered, 0.7);
                if (cells >= 64) {
                    EXPECT_LT(ordered, 0.72 * rows);
                }
            }
}

}  // namespace
}  // namespace carat
