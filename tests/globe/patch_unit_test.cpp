// The 4-8 pattern of a patch, and how the pattern of one level nests in that of the level above.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "carat/globe/patch.hpp"
#include "design_diamond.hpp"

namespace carat::test {
namespace {

struct Index {
    int i = 0, j = 0;
    friend auto operator<=>(const Index&, const Index&) = default;
};

// Storage order of the header: rows r, columns c <= r.
std::vector<Index> vertices(int side, int cells) {
    std::vector<Index> out;
    for (int r = 0; r <= cells; ++r)
        for (int c = 0; c <= r; ++c) out.push_back(side == 0 ? Index{r, c} : Index{c, r});
    return out;
}

std::vector<std::array<Index, 3>> triangles(int side, int cells) {
    const std::vector<Index> v = vertices(side, cells);
    std::vector<std::array<Index, 3>> out;
    for (const auto& t : half_triangles(side, cells)) out.push_back({v.at(t[0]), v.at(t[1]), v.at(t[2])});
    return out;
}

int double_area(const std::array<Index, 3>& t) {
    return (t[1].i - t[0].i) * (t[2].j - t[0].j) - (t[1].j - t[0].j) * (t[2].i - t[0].i);
}

using Sides = std::map<std::set<Index>, int>;  // how many triangles have the edge

Sides sides(int side, int cells) {
    Sides out;
    for (const auto& t : triangles(side, cells))
        for (std::size_t k = 0; k < 3; ++k) ++out[{t[k], t[(k + 1) % 3]}];
    return out;
}

class EveryPatch : public ::testing::TestWithParam<std::tuple<int, int>> {
  protected:
    int side() const { return std::get<0>(GetParam()); }
    int cells() const { return std::get<1>(GetParam()); }
    bool inside(int i, int j) const { return side() == 0 ? i >= j : i <= j; }
};

INSTANTIATE_TEST_SUITE_P(SideAndCells, EveryPatch,
                         ::testing::Combine(::testing::Values(0, 1),
                                            ::testing::Values(1, 2, 4, 8, 16, 32, 64, 128)));

TEST_P(EveryPatch, VerticesAreNumberedInStorageOrder) {
    const std::vector<Index> v = vertices(side(), cells());
    EXPECT_EQ(v.size(), half_vertex_count(cells()));
    EXPECT_EQ(v.size(), static_cast<std::size_t>((cells() + 1) * (cells() + 2) / 2));  // N(N+1)/2
    for (std::size_t k = 0; k < v.size(); ++k) EXPECT_EQ(half_vertex_index(v[k].i, v[k].j), k);
}

TEST_P(EveryPatch, HasOneTriangleForEachCell) {
    EXPECT_EQ(triangles(side(), cells()).size(), static_cast<std::size_t>(cells() * cells()));
}

TEST_P(EveryPatch, TrianglesAreHalfCellsInsideTheHalfAndCounterClockwise) {
    int sum = 0;
    for (const auto& t : triangles(side(), cells())) {
        EXPECT_EQ(double_area(t), 1);  // positive: counter-clockwise with i x j outwards
        sum += double_area(t);
        for (const Index& v : t) EXPECT_TRUE(inside(v.i, v.j));
    }
    EXPECT_EQ(sum, cells() * cells());  // twice the area of the half
}

TEST_P(EveryPatch, InnerEdgesAreSharedByTwoTrianglesAndBorderEdgesByOne) {
    const auto on_border = [&](const std::set<Index>& edge) {
        const auto all = [&](auto test) { return std::all_of(edge.begin(), edge.end(), test); };
        return all([](const Index& v) { return v.i == v.j; }) ||
               all([](const Index& v) { return std::min(v.i, v.j) == 0; }) ||
               all([&](const Index& v) { return std::max(v.i, v.j) == cells(); });
    };
    for (const auto& [edge, count] : sides(side(), cells())) EXPECT_EQ(count, on_border(edge) ? 1 : 2);
}

TEST_P(EveryPatch, EveryCellIsCutThroughItsVertexWithBothIndicesOdd) {
    const Sides edges = sides(side(), cells());
    for (int i = 0; i < cells(); ++i)
        for (int j = 0; j < cells(); ++j) {
            if (!inside(i, j)) continue;
            const Index odd{i % 2 != 0 ? i : i + 1, j % 2 != 0 ? j : j + 1};
            const Index opposite{2 * i + 1 - odd.i, 2 * j + 1 - odd.j};
            EXPECT_EQ(edges.count({odd, opposite}), 1u) << i << ' ' << j;
            const std::set<Index> crossing{{odd.i, opposite.j}, {opposite.i, odd.j}};
            EXPECT_EQ(edges.count(crossing), 0u) << i << ' ' << j;
            EXPECT_EQ(main_diagonal(i, j), (odd.i - i) == (odd.j - j)) << i << ' ' << j;
        }
}

TEST_P(EveryPatch, RefinedCellCentresLieOnEdges) {
    // In doubled indices: the centre of each cell is the middle of some edge.
    std::set<Index> middles;
    for (const auto& [edge, count] : sides(side(), cells()))
        middles.insert({edge.begin()->i + edge.rbegin()->i, edge.begin()->j + edge.rbegin()->j});
    for (int i = 0; i < cells(); ++i)
        for (int j = 0; j < cells(); ++j)
            if (inside(i, j)) {
                EXPECT_EQ(middles.count({2 * i + 1, 2 * j + 1}), 1u) << i << ' ' << j;
            }
}

TEST(Patch, BothHalvesHaveTheSameVerticesOnTheirCommonEdge) {
    for (const int cells : {1, 4, 64}) {
        std::set<std::set<Index>> diagonal[2];
        for (const int side : {0, 1})
            for (const auto& [edge, count] : sides(side, cells))
                if (edge.begin()->i == edge.begin()->j && edge.rbegin()->i == edge.rbegin()->j)
                    diagonal[side].insert(edge);
        EXPECT_EQ(diagonal[0].size(), static_cast<std::size_t>(cells));
        EXPECT_EQ(diagonal[0], diagonal[1]);
    }
}

TEST(Patch, IndicesOfTheLargestPatchFit16Bits) {
    for (const int side : {0, 1})
        for (const auto& t : half_triangles(side, 128))
            for (const std::uint16_t v : t) EXPECT_LT(v, half_vertex_count(128));
    EXPECT_LT(half_vertex_count(128), 65536u);
}

// --- interpolation weights

void expect_weights(double x, double y, int cells) {
    const TriangleWeights w = triangle_weights(x, y, cells);
    double sum = 0, back_x = 0, back_y = 0;
    std::set<Index> corners;
    for (std::size_t k = 0; k < 3; ++k) {
        ASSERT_GE(w.weight[k], 0) << x << ' ' << y;
        ASSERT_LE(w.weight[k], 1) << x << ' ' << y;
        sum += w.weight[k];
        back_x += w.weight[k] * w.vertex[k][0];
        back_y += w.weight[k] * w.vertex[k][1];
        corners.insert({w.vertex[k][0], w.vertex[k][1]});
    }
    ASSERT_NEAR(sum, 1, 3e-16) << x << ' ' << y;
    ASSERT_NEAR(back_x, x, 1e-15 * cells);
    ASSERT_NEAR(back_y, y, 1e-15 * cells);
    static std::map<int, std::set<std::set<Index>>> patterns;
    std::set<std::set<Index>>& pattern = patterns[cells];
    if (pattern.empty())
        for (const int side : {0, 1})
            for (const auto& t : triangles(side, cells)) pattern.insert({t[0], t[1], t[2]});
    ASSERT_EQ(pattern.count(corners), 1u) << x << ' ' << y;
}

TEST(Weights, AreNotNegativeSumToOneAndGiveThePlaceBack) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int n = 0; n < 100'000; ++n) expect_weights(random.real(0, 64), random.real(0, 64), 64);
    for (int n = 0; n < 100'000; ++n) {  // within rounding of vertices and edges
        const auto near = [&](double v) { return std::clamp(v + random.real(-4e-16, 4e-16), 0.0, 8.0); };
        const double i = random.real(0, 8), k = std::round(random.real(0, 8));
        expect_weights(near(i), near(i), 8);
        expect_weights(near(k), near(i), 8);
        expect_weights(near(i), near(std::max(0.0, k - i)), 8);
        expect_weights(near(k), near(std::round(i)), 8);
    }
    expect_weights(0.5 + 0x1p-53, 0.5, 2);  // the sum rounds to 1 from above
}

TEST(Weights, AtAVertexThatVertexHasAll) {
    for (const int cells : {1, 2, 8})
        for (int i = 0; i <= cells; ++i)
            for (int j = 0; j <= cells; ++j) {
                const TriangleWeights w = triangle_weights(i, j, cells);
                double own = 0;
                for (std::size_t k = 0; k < 3; ++k)
                    if (w.vertex[k] == std::array{i, j}) own += w.weight[k];
                EXPECT_EQ(own, 1);
            }
}

TEST(Weights, StayInTheHalfOfThePlace) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int n = 0; n < 50'000; ++n) {
        const double x = random.real(0, 16), y = random.real(0, 16);
        for (const auto& v : triangle_weights(x, y, 16).vertex) {
            const int above = x >= y ? v[0] - v[1] : v[1] - v[0];
            ASSERT_GE(above, 0) << x << ' ' << y;
        }
    }
}

// --- nesting

// Twice the signed area in the face's plane, seen from outside.
Int128 turn(const LatticeVector& p, const LatticeVector& q, const LatticeVector& r,
            const LatticeVector& normal) {
    const LatticeVector u = q - p, v = r - p;
    const Int128 x = Int128{u.y} * v.z - Int128{u.z} * v.y, y = Int128{u.z} * v.x - Int128{u.x} * v.z,
                 z = Int128{u.x} * v.y - Int128{u.y} * v.x;
    return x * normal.x + y * normal.y + z * normal.z;
}

std::vector<std::array<LatticeVector, 3>> lattice_triangles(const Half& h, int cells) {
    const HalfFrame f = half_frame(h, cells);
    std::vector<std::array<LatticeVector, 3>> out;
    for (const auto& t : triangles(h.side, cells)) {
        out.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) out.back()[k] = wide(f.vertex(t[k].i, t[k].j));
    }
    return out;
}

// Every finer triangle lies in one coarser triangle, and those in it have together its area.
void expect_nested(const Half& h, int cells) {
    const DesignDiamond d = design_diamond(h.diamond.centre(), h.diamond.level());
    const LatticeVector normal = face_normal(d.face[static_cast<std::size_t>(h.side)]);
    std::vector<std::array<LatticeVector, 3>> fine;
    for (const Half& k : child_halves(h))
        for (const auto& t : lattice_triangles(k, cells)) fine.push_back(t);
    const auto coarse = lattice_triangles(h, cells);
    std::vector<Int128> covered(coarse.size(), 0);
    for (const auto& t : fine) {
        int holders = 0;
        for (std::size_t k = 0; k < coarse.size(); ++k) {
            const LatticeVector &p = coarse[k][0], &q = coarse[k][1], &r = coarse[k][2];
            const bool inside = std::all_of(t.begin(), t.end(), [&](const LatticeVector& v) {
                return turn(p, q, v, normal) >= 0 && turn(q, r, v, normal) >= 0 && turn(r, p, v, normal) >= 0;
            });
            if (!inside) continue;
            ++holders;
            const Int128 area = turn(t[0], t[1], t[2], normal);
            ASSERT_TRUE(area > 0) << "clockwise";
            covered[k] += area;
        }
        ASSERT_EQ(holders, 1) << to_string(h.diamond) << " half " << h.side;
    }
    for (std::size_t k = 0; k < coarse.size(); ++k)
        ASSERT_TRUE(covered[k] == turn(coarse[k][0], coarse[k][1], coarse[k][2], normal));
}

TEST(Nesting, EveryCoarseTriangleIsAUnionOfFinerOnes) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int level = 0; level < kDeepestId; ++level)
        for (int n = 0; n < 8; ++n)
            for (const int side : {0, 1}) expect_nested({random_diamond(random, level), side}, 8);
}

TEST(Nesting, HoldsForTheWholePatch) {
    expect_nested({root_diamond(5), 0}, 64);            // even
    expect_nested({child(root_diamond(3), 2), 1}, 64);  // odd, on a cube edge
}

}  // namespace
}  // namespace carat::test
