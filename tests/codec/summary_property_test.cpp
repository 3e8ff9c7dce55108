// Summaries: codes round outwards, gather_half copies by lattice point, max_deviation and height_range are
// exact.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>

#include "carat/codec/heights.hpp"
#include "carat/codec/summary.hpp"
#include "carat/globe/patch.hpp"
#include "globe/design_diamond.hpp"
#include "globe/diamond_levels.hpp"
#include "mini_builder.hpp"
#include "summary_code.hpp"

namespace carat::test {
namespace {

// ---- codes ----

SummaryValues random_summary(Random& random) {
    const std::int64_t reach = std::int64_t{1} << random.integer(0, 30);
    const auto height = [&] { return static_cast<std::int32_t>(random.integer(-reach, reach)); };
    const std::int32_t a = height(), b = height();
    const double delta = random.integer(0, 8) == 0 ? 0.0 : std::exp2(random.real(-39, 40));
    return {std::min(a, b), std::max(a, b), delta};
}

TEST(SummaryCode, RoundsOutwardsAndTwiceIsOnce) {
    Random random;
    SCOPED_TRACE(random.trace());
    double worst = 1;
    for (int round = 0; round < 20000; ++round) {
        const SummaryGrid grid(std::exp2(random.real(0, 30)), std::exp2(random.real(-12, 0)),
                               static_cast<int>(random.integer(2, 7)));
        const int level = static_cast<int>(random.integer(0, 50));
        const SummaryValues v = random_summary(random), s = grid.rounded(v, level),
                            t = grid.rounded(s, level);
        ASSERT_LE(s.min, v.min);
        ASSERT_GE(s.max, v.max);
        ASSERT_GE(s.delta, v.delta);
        ASSERT_LT(std::int64_t{v.min} - s.min, grid.unit(level)) << "no looser than need be";
        ASSERT_LT(std::int64_t{s.max} - v.max, grid.unit(level));
        if (v.delta > 0) worst = std::max(worst, s.delta / v.delta);
        ASSERT_EQ(t.min, s.min);
        ASSERT_EQ(t.max, s.max);
        ASSERT_EQ(t.delta, s.delta);
    }
    std::cout << "greatest overestimation of delta by its code " << worst << '\n';
    EXPECT_LT(worst, 1.0453);
}

// Rounding what goes into the half above changes none of its heights: a coarser grid contains the finer one.
TEST(SummaryCode, RoundingOnTheWayUpIsRoundingAtTheTop) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int round = 0; round < 5000; ++round) {
        const SummaryGrid grid(6378137, std::exp2(random.real(-12, 0)), 6);
        const int level = static_cast<int>(random.integer(1, 50));
        ASSERT_EQ(grid.unit(level - 1) % grid.unit(level), 0);
        const SummaryValues v = random_summary(random);
        const SummaryValues steps = grid.rounded(grid.rounded(v, level), level - 1),
                            once = grid.rounded(v, level - 1);
        ASSERT_EQ(steps.min, once.min);
        ASSERT_EQ(steps.max, once.max);
        ASSERT_EQ(steps.delta, once.delta);
    }
}

TEST(SummaryCode, WhatIsPutComesBack) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int round = 0; round < 3000; ++round) {
        const SummaryGrid grid(6378137, std::exp2(random.real(-12, 0)), 6);
        std::vector<std::pair<SummaryValues, int>> values;
        SummaryRange range;
        for (std::int64_t k = random.integer(1, 12); k > 0; --k) {
            const int level = static_cast<int>(random.integer(0, 50));
            values.emplace_back(grid.rounded(random_summary(random), level), level);
            range.include(values.back().first);
        }
        std::vector<std::byte> bytes;
        std::size_t expected = 0;
        for (const auto& [s, level] : values) {
            put_summary(bytes, s, range, grid.unit(level));
            expected += summary_bytes(s, range, grid.unit(level));
        }
        ASSERT_EQ(bytes.size(), expected);
        ByteParser in(bytes, "summaries");
        for (const auto& [s, level] : values) {
            const SummaryValues back = get_summary(in, range, grid.unit(level));
            ASSERT_EQ(back.min, s.min);
            ASSERT_EQ(back.max, s.max);
            ASSERT_EQ(back.delta, s.delta);
        }
        ASSERT_EQ(in.left(), 0u);
    }
}

TEST(SummaryCode, EveryDeltaIndexDecodesInOrder) {
    for (int k = 1; k <= kGreatestDeltaIndex; ++k) {
        ASSERT_GT(delta_of_index(k), delta_of_index(k - 1));
        ASSERT_EQ(index_of_delta(delta_of_index(k)), k);
    }
    EXPECT_EQ(index_of_delta(0), 0);
    EXPECT_EQ(index_of_delta(1e300), kGreatestDeltaIndex);
    EXPECT_DOUBLE_EQ(delta_of_index(640), 1.0);
}

TEST(SummaryCode, ImpossibleSummariesAreCorrupt) {
    const auto read = [](std::vector<std::uint64_t> numbers) {
        std::vector<std::byte> bytes;
        for (const std::uint64_t x : numbers) put_varint(bytes, x);
        ByteParser in(bytes, "summary");
        SummaryRange range;
        range.min = 5;
        range.delta = 3;
        return get_summary(in, range, 1);
    };
    EXPECT_EQ(read({2, 3, 3}).max, 10);
    for (const std::vector<std::uint64_t>& bad :
         {std::vector<std::uint64_t>{0, 0, 4}, {0xFFFFFFFF, 0, 0}, {0, 0xFFFFFFFF, 0}, {0x7FFFFFFB, 0, 0}})
        EXPECT_THROW(read(bad), Error);
}

// ---- children take their half from their parents ----

// Value of a lattice point; all points of all grids differ with high probability.
std::int32_t token(const LatticePoint& p) { return static_cast<std::int32_t>(hash_value(p)); }

RefinedHeights tokens(DiamondId d, int n) {
    RefinedHeights r{n, Grid(static_cast<std::size_t>(n * n)),
                     Grid(static_cast<std::size_t>((n - 1) * (n - 1)))};
    for (int side = 0; side < 2; ++side) {
        const HalfFrame f = half_frame({d, side}, n - 1);
        for_half(n, side, [&](int i, int j) {
            r.v[static_cast<std::size_t>(i * n + j)] = token(f.vertex(i, j));
            if (i == n - 1 || j == n - 1) return;
            // Twice the centre is an integer even where the centre's half steps are not.
            const LatticeVector twice = wide(f.vertex(i, j)) + wide(f.vertex(i + 1, j + 1));
            r.c[static_cast<std::size_t>(i * (n - 1) + j)] =
                token(narrow({twice.x / 2, twice.y / 2, twice.z / 2}));
        });
    }
    return r;
}

void expect_gathered(DiamondId parent_id, int n) {
    const RefinedHeights refined = tokens(parent_id, n);
    for (int side = 0; side < 2; ++side)
        for (const Half& child : child_halves({parent_id, side})) {
            Grid out(static_cast<std::size_t>(n * n), 0);
            gather_half(refined, parent_id, child, out.data());
            const HalfFrame f = half_frame(child, n - 1);
            int wrong = 0;
            for_half(n, child.side, [&](int i, int j) {
                wrong += out[static_cast<std::size_t>(i * n + j)] != token(f.vertex(i, j)) ? 1 : 0;
            });
            ASSERT_EQ(wrong, 0) << to_string(parent_id) << " child " << to_string(child.diamond);
        }
}

TEST(Heights, AChildsVerticesAreTheParentsVerticesAndCentresAtTheSamePoints) {
    for (std::size_t l = 0; l <= 7; ++l)
        for (const DiamondId d : all_levels()[l]) expect_gathered(d, 9);
    for (const int p : {2, 4, 6})
        for_random(deepest_level(p) < kDeepestId ? deepest_level(p) - 1 : kDeepestId - 1,
                   [p](DiamondId d, int) {
                       if (p < 6 || d.bits() % 8 == 0) expect_gathered(d, (1 << p) + 1);
                   });
}

// ---- deviation and range ----

using Surfaces = std::map<DiamondId, Grid>;

Grid random_grid(Random& random, int n, std::int64_t reach) {
    Grid g(static_cast<std::size_t>(n * n));
    for (auto& x : g) x = static_cast<std::int32_t>(random.integer(-reach, reach));
    return g;
}

// Index position, in a coarse half's grid, of a lattice point.
std::array<double, 2> index_of(const LatticePoint& p, const HalfFrame& f) {
    const LatticeVector d = wide(p) - f.origin;
    const auto along = [&](const LatticeVector& axis) {
        double num = 0, den = 0;
        for (int k = 0; k < 3; ++k) {
            num += static_cast<double>(d[k]) * static_cast<double>(axis[k]);
            den += static_cast<double>(axis[k]) * static_cast<double>(axis[k]);
        }
        return num / den;
    };
    return {along(f.u), along(f.v)};
}

double brute_deviation(const Grid& coarse, const Half& top, const Grid& fine, const Half& bottom, int n) {
    const HalfFrame c = half_frame(top, n - 1), f = half_frame(bottom, n - 1);
    double worst = 0;
    for_half(n, bottom.side, [&](int i, int j) {
        const auto [x, y] = index_of(f.vertex(i, j), c);
        const TriangleWeights w = triangle_weights(x, y, n - 1);
        double h = 0;
        for (std::size_t k = 0; k < 3; ++k)
            h += w.weight[k] * coarse[static_cast<std::size_t>(w.vertex[k][0] * n + w.vertex[k][1])];
        worst = std::max(worst, std::abs(h - fine[static_cast<std::size_t>(i * n + j)]));
    });
    return worst;
}

TEST(Summary, MaxDeviationIsExactForAllLevelDifferences) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const int n : {5, 9, 17, 65})
        for (int down = 1; down <= 6; ++down)
            for (int round = 0; round < (n > 17 ? 6 : 60); ++round) {
                const Half top{random_diamond(random, static_cast<int>(random.integer(0, 40))),
                               static_cast<int>(random.integer(0, 1))};
                Half bottom = top;
                for (int k = 0; k < down; ++k)
                    bottom = child_halves(bottom)[static_cast<std::size_t>(random.integer(0, 1))];
                const std::int64_t reach = round % 3 == 0 ? kGreatestHeight : 1000;
                const Grid coarse = random_grid(random, n, reach), fine = random_grid(random, n, reach);
                const std::int64_t dev = max_deviation(coarse.data(), top, fine.data(), bottom, n);
                // All weights are multiples of 1/8 and all sums below 2^53: the doubles are exact.
                ASSERT_EQ(static_cast<double>(dev) / 8, brute_deviation(coarse, top, fine, bottom, n))
                    << "n " << n << " down " << down << ' ' << to_string(top.diamond);
            }
}

TEST(Summary, DeviationAtVerticesIsTheGreatestAnywhere) {
    Random random;
    SCOPED_TRACE(random.trace());
    const int n = 9;
    for (int down = 1; down <= 6; ++down)
        for (int round = 0; round < 20; ++round) {
            const Half top{random_diamond(random, 12), round % 2};
            Half bottom = top;
            for (int k = 0; k < down; ++k)
                bottom = child_halves(bottom)[static_cast<std::size_t>(random.integer(0, 1))];
            const Grid coarse = random_grid(random, n, 1000), fine = random_grid(random, n, 1000);
            const double dev =
                static_cast<double>(max_deviation(coarse.data(), top, fine.data(), bottom, n)) / 8;
            const HalfFrame c = half_frame(top, n - 1), f = half_frame(bottom, n - 1);
            for (int k = 0; k < 3000; ++k) {
                double s = random.real(0, n - 1), t = random.real(0, n - 1);
                if ((s < t) == (bottom.side == 0)) std::swap(s, t);
                std::array<double, 3> place{};
                for (int a = 0; a < 3; ++a)
                    place[static_cast<std::size_t>(a)] = static_cast<double>(f.origin[a] - c.origin[a]) +
                                                         s * static_cast<double>(f.u[a]) +
                                                         t * static_cast<double>(f.v[a]);
                const auto along = [&](const LatticeVector& axis) {
                    double num = 0, den = 0;
                    for (int a = 0; a < 3; ++a) {
                        num += place[static_cast<std::size_t>(a)] * static_cast<double>(axis[a]);
                        den += static_cast<double>(axis[a]) * static_cast<double>(axis[a]);
                    }
                    return num / den;
                };
                const auto height = [&](const Grid& g, double x, double y) {
                    const TriangleWeights w = triangle_weights(x, y, n - 1);
                    double h = 0;
                    for (std::size_t v = 0; v < 3; ++v)
                        h += w.weight[v] * g[static_cast<std::size_t>(w.vertex[v][0] * n + w.vertex[v][1])];
                    return h;
                };
                ASSERT_LE(std::abs(height(coarse, along(c.u), along(c.v)) - height(fine, s, t)), dev + 1e-6);
            }
        }
}

TEST(Summary, HeightRangeAgreesWithItsTriangles) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const int n : {5, 9, 17, 65})
        for (int side = 0; side < 2; ++side) {
            const Grid g = random_grid(random, n, kGreatestHeight);
            const HeightRange r = height_range(g.data(), n, side);
            std::int32_t least = INT32_MAX, greatest = INT32_MIN;
            Grid by_index(half_vertex_count(n - 1));
            for_half(n, side, [&](int i, int j) {
                const std::int32_t h = g[static_cast<std::size_t>(i * n + j)];
                least = std::min(least, h);
                greatest = std::max(greatest, h);
                by_index[half_vertex_index(i, j)] = h;
            });
            EXPECT_EQ(r.min, least);
            EXPECT_EQ(r.max, greatest);
            std::int64_t range = 0;
            for (const auto& t : half_triangles(side, n - 1))
                for (int k = 0; k < 3; ++k)
                    range = std::max(range, std::abs(std::int64_t{by_index[t[static_cast<std::size_t>(k)]]} -
                                                     by_index[t[static_cast<std::size_t>((k + 1) % 3)]]));
            EXPECT_GE(r.cell_range, range);
            EXPECT_LE(r.cell_range, std::int64_t{greatest} - least);
        }
}

}  // namespace
}  // namespace carat::test
