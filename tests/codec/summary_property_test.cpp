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

TEST(SummaryCode, RoundsOutwardsAlways) {
    Random random;
    SCOPED_TRACE(random.trace());
    double worst = 1;
    for (int round = 0; round < 3000; ++round) {
        const std::int64_t reach = std::int64_t{1} << random.integer(0, 31);
        const auto height = [&] {
            return static_cast<std::int32_t>(
                std::clamp<std::int64_t>(random.integer(-reach, reach), INT32_MIN, INT32_MAX));
        };
        std::vector<SummaryValues> values(static_cast<std::size_t>(random.integer(1, 12)));
        SummaryRange range{INT32_MAX, INT32_MIN, 0};
        for (auto& v : values) {
            const std::int32_t a = height(), b = height();
            v = {std::min(a, b), std::max(a, b), round % 9 == 0 ? 0.0 : std::exp2(random.real(-30, 30))};
            range.include(v);
        }
        for (const auto& v : values) {
            const SummaryValues s = decode_summary(encode_summary(v, range), range);
            ASSERT_LE(s.min, v.min);
            ASSERT_GE(s.max, v.max);
            ASSERT_GE(s.delta, v.delta);
            ASSERT_GE(s.min, range.min);
            ASSERT_LE(s.max, range.max);
            // Within one step of the code: no looser than need be.
            const double step = (static_cast<double>(range.max) - range.min) / 255 + 1;
            ASSERT_LT(v.min - static_cast<double>(s.min), step);
            ASSERT_LT(static_cast<double>(s.max) - v.max, step);
            ASSERT_LE(s.delta, static_cast<double>(range.delta));
            if (v.delta > static_cast<double>(range.delta) / 32768)
                worst = std::max(worst, s.delta / v.delta);
        }
    }
    std::cout << "greatest overestimation of delta by its code " << worst << '\n';
    EXPECT_LT(worst, 1.0453);
}

TEST(SummaryCode, EveryCodeDecodesInOrder) {
    const SummaryRange range{INT32_MIN, INT32_MAX, 3e38f};
    for (int k = 1; k < 256; ++k) {
        const auto low = static_cast<std::uint8_t>(k - 1), high = static_cast<std::uint8_t>(k);
        EXPECT_LT(decode_summary({low, low, low}, range).min, decode_summary({high, high, high}, range).min);
        EXPECT_LT(decode_summary({low, low, low}, range).max, decode_summary({high, high, high}, range).max);
        EXPECT_GT(decode_delta(low, range.delta), decode_delta(high, range.delta));
    }
    EXPECT_EQ(decode_summary({0, 0, 0}, range).min, INT32_MIN);
    EXPECT_EQ(decode_summary({255, 255, 0}, range).min, INT32_MAX);
    EXPECT_EQ(decode_summary({0, 255, 0}, range).max, INT32_MAX);
}

TEST(SummaryCode, DeltaOfZeroAndTinyRangesStaysABound) {
    for (const float greatest : {0.0f, 1e-45f, 1e-38f, 1.0f})
        for (const double share : {0.0, 1e-9, 0.3, 1.0}) {
            const double delta = share * static_cast<double>(greatest);
            EXPECT_GE(decode_delta(encode_delta(delta, greatest), greatest), delta);
        }
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
    for (const int n : {5, 9, 17})
        for (int down = 1; down <= 6; ++down)
            for (int round = 0; round < 60; ++round) {
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
