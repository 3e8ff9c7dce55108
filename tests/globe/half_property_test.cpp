// Halves: index grids, nesting of samples, tiling of the sphere, neighbours. Exhaustive to level 9, then at
// random to the deepest level.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "carat/globe/diamond.hpp"
#include "design_diamond.hpp"
#include "diamond_levels.hpp"

namespace carat::test {
namespace {

std::array<LatticePoint, 3> triangle(const Half& h) {  // a, right-angled corner, b
    const DiamondCorners c = corners(h.diamond);
    return {c.a, c.x[static_cast<std::size_t>(h.side)], c.b};
}

std::set<LatticePoint> vertex_set(const Half& h) {
    const auto t = triangle(h);
    return {t.begin(), t.end()};
}

int face_of_half(const Half& h) {
    return design_diamond(h.diamond.centre(), h.diamond.level()).face[static_cast<std::size_t>(h.side)];
}

// Square of a leg: twice the half's area on the cube, in lattice units.
Int128 double_area(const Half& h) {
    const auto t = triangle(h);
    const LatticeVector p = wide(t[1]) - wide(t[0]), q = wide(t[2]) - wide(t[1]);
    EXPECT_EQ(dot128(p, p), dot128(q, q));
    EXPECT_EQ(dot128(p, q), 0);
    return dot128(p, p);
}

template <class Visit>
void for_halves(int last_random_level, Visit visit) {
    const auto both = [&](DiamondId d, int level) {
        visit(Half{d, 0}, level);
        visit(Half{d, 1}, level);
    };
    for_all(both);
    for_random(last_random_level, both);
}

// The index grid of the design: odd (i,j) = m + s (a t + |b| d), even affine between the corners.
void expect_design_grid(const Half& h, int level, int cells) {
    const DesignDiamond design = design_diamond(h.diamond.centre(), level);
    const HalfFrame frame = half_frame(h, cells);
    const LatticeVector x = design.x[static_cast<std::size_t>(h.side)];
    const LatticeVector d = x - design.c, t = design.b - design.c;  // s d and s t on odd levels
    const int stride = std::max(1, cells / 64);
    int wrong = 0;
    for (int i = 0; i <= cells; i += stride)
        for (int j = 0; j <= cells; j += stride) {
            if (h.side == 0 ? i < j : i > j) continue;
            const LatticeVector scaled =
                cells * design.c + (i + j - cells) * t + std::abs(i - j) * d;  // cells times the vertex
            wrong += cells * wide(frame.vertex(i, j)) != scaled ? 1 : 0;
        }
    EXPECT_EQ(wrong, 0) << to_string(h.diamond) << " half " << h.side;
}

TEST(Half, IndexGridIsThatOfTheDesign) {
    for_all([](DiamondId d, int level) {
        for (const int side : {0, 1}) expect_design_grid({d, side}, level, level < 6 ? 64 : 8);
    });
    for_random(kDeepestId, [](DiamondId d, int level) {
        for (const int side : {0, 1}) expect_design_grid({d, side}, level, 8);
    });
}

TEST(Half, CornersOfTheGridAreThoseOfTheDiamond) {
    for_halves(kDeepestId, [](const Half& h, int) {
        const HalfFrame f = half_frame(h, 64);
        const DiamondCorners c = corners(h.diamond);
        EXPECT_EQ(f.vertex(0, 0), c.a);
        EXPECT_EQ(f.vertex(64, 64), c.b);
        EXPECT_EQ(f.vertex(32, 32), c.c);
        EXPECT_EQ(h.side == 0 ? f.vertex(64, 0) : f.vertex(0, 64), c.x[static_cast<std::size_t>(h.side)]);
    });
}

TEST(Half, IndexCrossProductPointsOutwards) {
    for_halves(kDeepestId, [](const Half& h, int) {
        const HalfFrame f = half_frame(h, 1);
        EXPECT_GT(dot128(cross(f.u, f.v), face_normal(face_of_half(h))), 0) << to_string(h.diamond);
    });
}

TEST(Half, GridReachesTheDeepestLevelForEverySize) {
    Random random;
    SCOPED_TRACE(random.trace());
    EXPECT_EQ(deepest_level(6), 50);
    for (int p = 6; p <= 10; ++p)
        for (int n = 0; n < 20; ++n)
            for (const int level : {deepest_level(p), deepest_level(p) - 1})
                expect_design_grid({random_diamond(random, level), n % 2}, level, 1 << p);
}

// Index of a lattice point in a parent's grid, doubled: a vertex has two even numbers, a cell centre two odd.
struct DoubledIndex {
    bool exact = true;
    std::int64_t i = 0, j = 0;
};
DoubledIndex doubled_index(const HalfFrame& f, const LatticeVector& p) {
    const LatticeVector offset = p - f.origin;
    const Int128 uu = dot128(f.u, f.u), i = 2 * dot128(offset, f.u), j = 2 * dot128(offset, f.v);
    const auto di = static_cast<std::int64_t>(i / uu), dj = static_cast<std::int64_t>(j / uu);
    return {i % uu == 0 && j % uu == 0 && di * f.u + dj * f.v == 2 * offset, di, dj};
}

// Every vertex of a child's half is a vertex or cell centre of the parent's half that holds it.
void expect_samples_coincide(const Half& parent_half, int cells) {
    const HalfFrame coarse = half_frame(parent_half, cells);
    for (const Half& child : child_halves(parent_half)) {
        const HalfFrame fine = half_frame(child, cells);
        // Both maps are affine with legs of integer length: check the frame, then walk in doubled indices.
        const DoubledIndex origin = doubled_index(coarse, fine.origin);
        const DoubledIndex u = doubled_index(coarse, coarse.origin + fine.u);
        const DoubledIndex v = doubled_index(coarse, coarse.origin + fine.v);
        ASSERT_TRUE(origin.exact && u.exact && v.exact) << to_string(child.diamond);
        int wrong = 0;
        for (int r = 0; r <= cells; ++r)
            for (int c = 0; c <= r; ++c) {
                const int i = child.side == 0 ? r : c, j = child.side == 0 ? c : r;
                const std::int64_t di = origin.i + i * u.i + j * v.i, dj = origin.j + i * u.j + j * v.j;
                const bool sample = (di - dj) % 2 == 0;
                const bool inside = di >= 0 && dj >= 0 && di <= 2 * cells && dj <= 2 * cells &&
                                    (parent_half.side == 0 ? di >= dj : di <= dj);
                wrong += sample && inside ? 0 : 1;
            }
        EXPECT_EQ(wrong, 0) << to_string(child.diamond) << " in " << to_string(parent_half.diamond);
    }
}

TEST(Half, ChildSamplesCoincideWithTheParentsRefinedSamples) {
    for (const int cells : {4, 64})
        for_all([&](DiamondId d, int) {
            for (const int side : {0, 1}) expect_samples_coincide({d, side}, cells);
        });
    for_random(kDeepestId - 1, [](DiamondId d, int) {
        for (const int side : {0, 1}) expect_samples_coincide({d, side}, 64);
    });
}

// The plain statement by sets of lattice points: the two child halves hold all refined samples of a half, and
// nothing else.
void expect_same_sample_sets(const Half& h, int cells) {
    const HalfFrame f = half_frame(h, cells);
    std::set<LatticePoint> refined;
    for (int i = 0; i <= 2 * cells; ++i)
        for (int j = 0; j <= 2 * cells; ++j) {
            if ((i - j) % 2 != 0 || (h.side == 0 ? i < j : i > j)) continue;
            const LatticeVector doubled = i * f.u + j * f.v;  // always even while a child has a grid
            ASSERT_TRUE(doubled.x % 2 == 0 && doubled.y % 2 == 0 && doubled.z % 2 == 0);
            refined.insert(narrow(f.origin + LatticeVector{doubled.x / 2, doubled.y / 2, doubled.z / 2}));
        }
    std::set<LatticePoint> fine;
    for (const Half& child : child_halves(h)) {
        const HalfFrame g = half_frame(child, cells);
        for (int i = 0; i <= cells; ++i)
            for (int j = 0; j <= cells; ++j)
                if (child.side == 0 ? i >= j : i <= j) fine.insert(g.vertex(i, j));
    }
    EXPECT_EQ(fine, refined) << to_string(h.diamond) << " half " << h.side;
}

TEST(Half, ChildHalvesHoldExactlyTheRefinedSamples) {
    for_all([](DiamondId d, int level) {
        for (const int side : {0, 1})
            if (level <= 5 || d.bits() % 7 == 0) expect_same_sample_sets({d, side}, level <= 2 ? 64 : 4);
    });
    for_random(kDeepestId - 1, [](DiamondId d, int) { expect_same_sample_sets({d, 0}, 2); });
}

TEST(Half, ParentsAgreeOnTheSamplesOfTheirCommonChild) {
    // The child's two halves meet on its longest edge: both parents hold that edge's samples.
    for_halves(kDeepestId, [](const Half& h, int level) {
        if (level == 0) return;
        const HalfFrame own = half_frame(h, 64), other = half_frame({h.diamond, 1 - h.side}, 64);
        for (const int i : {0, 1, 31, 32, 63, 64}) EXPECT_EQ(own.vertex(i, i), other.vertex(i, i));
    });
}

TEST(Half, ChildHalvesTileTheirParentHalf) {
    const auto check = [](const Half& h, int level) {
        const auto [a, x, b] = triangle(h);
        const LatticePoint c = h.diamond.centre();
        const std::array<Half, 2> k = child_halves(h);
        EXPECT_EQ(k[0].diamond.level(), level + 1);
        EXPECT_EQ(k[1].diamond.level(), level + 1);
        EXPECT_EQ(vertex_set(k[0]), (std::set{a, c, x})) << to_string(h.diamond);
        EXPECT_EQ(vertex_set(k[1]), (std::set{x, c, b})) << to_string(h.diamond);
        for (const Half& child : k) {
            EXPECT_EQ(triangle(child)[1], c);
            EXPECT_EQ(2 * double_area(child), double_area(h));
            EXPECT_EQ(face_of_half(child), face_of_half(h));
            EXPECT_EQ(parent_half(child), h) << to_string(child.diamond) << " half " << child.side;
        }
    };
    for_halves(kDeepestId - 1, check);
}

TEST(Half, ParentHalfHasThisHalfAmongItsChildren) {
    for_halves(kDeepestId, [](const Half& h, int level) {
        const std::optional<Half> p = parent_half(h);
        ASSERT_EQ(p.has_value(), level > 0);
        if (!p) return;
        const std::array<Half, 2> k = child_halves(*p);
        EXPECT_EQ(std::count(k.begin(), k.end(), h), 1) << to_string(h.diamond) << " half " << h.side;
    });
}

TEST(Half, AreasOfALevelSumToTheCube) {
    std::array<Int128, kExhaustive + 1> sum{};
    for_all([&](DiamondId d, int level) {
        sum[static_cast<std::size_t>(level)] += double_area({d, 0}) + double_area({d, 1});
    });
    const Int128 side = 2 * kLatticeExtent;
    for (const Int128 s : sum) EXPECT_TRUE(s == 2 * kFaces * side * side);
}

// Degrees of the triangle around a point of its plane: 360 strictly inside, 180 on an edge, the corner's own
// angle at a corner, 0 outside.
int angle_at(const Half& h, const LatticePoint& p) {
    const auto t = triangle(h);
    const LatticeVector normal = face_normal(face_of_half(h));
    const int turn = h.side == 0 ? 1 : -1;  // a, x, b runs clockwise in half 1
    std::array<bool, 3> on_line{};
    for (std::size_t k = 0; k < 3; ++k) {
        const LatticeVector edge = wide(t[(k + 1) % 3]) - wide(t[k]), to = wide(p) - wide(t[k]);
        // Only the component along the normal, in 128 bits.
        const int axis = normal.x != 0 ? 0 : normal.y != 0 ? 1 : 2;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const Int128 across = (Int128{edge[u]} * to[v] - Int128{edge[v]} * to[u]) * normal[axis] * turn;
        if (across < 0) return 0;
        on_line[k] = across == 0;
    }
    if (on_line[0] && on_line[1]) return 90;  // at x
    if ((on_line[1] && on_line[2]) || (on_line[2] && on_line[0])) return 45;
    return on_line[0] || on_line[1] || on_line[2] ? 180 : 360;
}

// Random places, places on edges of halves and their corners, on cube edges and cube corners.
std::vector<LatticePoint> places(Random& random) {
    std::vector<LatticePoint> out;
    for (int n = 0; n < 80; ++n) {
        out.push_back(random_target(random));
        const DiamondCorners c = corners(random_diamond(random, static_cast<int>(random.integer(0, 10))));
        out.push_back(c.c);
        out.push_back(c.a);
        out.push_back(c.x[1]);
    }
    for (int corner = 0; corner < 8; ++corner) {
        const auto at = [&](int bit) {
            return static_cast<std::int32_t>((corner >> bit & 1) != 0 ? kLatticeExtent : -kLatticeExtent);
        };
        out.push_back({at(0), at(1), at(2)});
    }
    return out;
}

TEST(Half, EveryPlaceIsCoveredExactlyOnceOnEveryLevel) {
    Random random;
    SCOPED_TRACE(random.trace());
    const std::vector<LatticePoint> all = places(random);
    for (std::size_t l = 0; l <= kExhaustive; ++l) {
        std::map<int, std::vector<Half>> on_face;
        for (const DiamondId d : all_levels()[l])
            for (const int side : {0, 1}) on_face[face_of_half({d, side})].push_back({d, side});
        std::vector<int> degrees(all.size(), 0);
        for (const auto& [face, halves] : on_face)
            for (const Half& h : halves)
                for (std::size_t k = 0; k < all.size(); ++k)
                    if (carat::on_face(all[k], face)) degrees[k] += angle_at(h, all[k]);
        for (std::size_t k = 0; k < all.size(); ++k) {
            const bool cube_corner = faces_of(wide(all[k])).size() == 3;
            EXPECT_EQ(degrees[k], cube_corner ? 270 : 360)
                << ::testing::PrintToString(all[k]) << " on level " << l;
        }
    }
}

using Edge = std::set<LatticePoint>;

Edge edge_of(const Half& h, int edge) {
    const auto [a, x, b] = triangle(h);
    if (edge == 0) return {a, b};
    return edge == 1 ? Edge{a, x} : Edge{x, b};
}

TEST(Half, EveryEdgeIsSharedByExactlyTwoHalves) {
    for (std::size_t l = 0; l <= kExhaustive; ++l) {
        std::map<Edge, std::vector<Half>> sharing;
        for (const DiamondId d : all_levels()[l])
            for (const int side : {0, 1})
                for (int e = 0; e < 3; ++e) sharing[edge_of({d, side}, e)].push_back({d, side});
        for (const auto& [edge, halves] : sharing) {
            ASSERT_EQ(halves.size(), 2u) << "level " << l;
            for (const std::size_t k : {0u, 1u})
                for (int e = 0; e < 3; ++e) {
                    if (edge_of(halves[k], e) != edge) continue;
                    EXPECT_EQ(neighbour(halves[k], e), halves[1 - k]);
                }
        }
    }
}

TEST(Half, NeighboursShareTheEdgeAndAreMutual) {
    for_halves(kDeepestId, [](const Half& h, int level) {
        for (int e = 0; e < 3; ++e) {
            const Half n = neighbour(h, e);
            EXPECT_NE(n, h);
            EXPECT_EQ(n.diamond.level(), level);
            int back = -1;
            for (int f = 0; f < 3; ++f)
                if (edge_of(n, f) == edge_of(h, e)) back = f;
            ASSERT_GE(back, 0) << to_string(h.diamond) << " half " << h.side << " edge " << e;
            EXPECT_EQ(neighbour(n, back), h);
            EXPECT_EQ(back == 0, e == 0) << "the longest edge meets a longest edge";
        }
    });
}

TEST(Half, NeighboursHaveTheSameVerticesOnTheCommonEdge) {
    constexpr int kCells = 4;
    const auto edge_samples = [](const Half& h, int e) {
        const HalfFrame f = half_frame(h, kCells);
        std::set<LatticePoint> out;
        for (int k = 0; k <= kCells; ++k) {
            const int i = e == 0 || e == 1 ? k : kCells, j = e == 0 ? k : e == 1 ? 0 : k;
            out.insert(h.side == 0 ? f.vertex(i, j) : f.vertex(j, i));
        }
        return out;
    };
    for_halves(kDeepestId, [&](const Half& h, int) {
        for (int e = 0; e < 3; ++e) {
            const Half n = neighbour(h, e);
            int shared = 0;
            for (int f = 0; f < 3; ++f) shared += edge_samples(n, f) == edge_samples(h, e) ? 1 : 0;
            EXPECT_EQ(shared, 1) << to_string(h.diamond) << " half " << h.side << " edge " << e;
        }
    });
}

}  // namespace
}  // namespace carat::test
