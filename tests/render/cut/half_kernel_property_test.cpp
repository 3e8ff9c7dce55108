// The loops over heights do on every vector unit what is written out here.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <random>

#include "carat/globe/patch.hpp"
#include "carat/globe/sphere.hpp"
#include "half_kernel.hpp"
#include "render/cut/vector_target.hpp"

namespace carat::test {
namespace {

constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min(),
                       kGreatest = std::numeric_limits<std::int32_t>::max();

std::vector<std::int32_t> random_heights(std::size_t count, std::int32_t least, std::int32_t greatest,
                                         std::mt19937& generator) {
    std::uniform_int_distribution<std::int32_t> height(least, greatest);
    std::vector<std::int32_t> out(count);
    for (std::int32_t& h : out) h = height(generator);
    return out;
}

// By the triangles that are drawn.
WholeRange plain_range(const std::vector<std::int32_t>& heights, int cells) {
    const auto [least, greatest] = std::minmax_element(heights.begin(), heights.end());
    WholeRange out{*least, *greatest, 0};
    for (const auto& t : half_triangles(0, cells)) {
        const auto [low, high] = std::minmax({heights[t[0]], heights[t[1]], heights[t[2]]});
        out.in_triangle =
            std::max(out.in_triangle, static_cast<std::uint32_t>(high) - static_cast<std::uint32_t>(low));
    }
    return out;
}

TEST(HalfKernel, RangeIsThatOfTheTriangles) {
    std::mt19937 generator(11);
    for (const std::int64_t target : vector_targets()) {
        const OneVectorTarget one(target);
        for (const int cells : {4, 8, 16, 32, 64, 128})
            for (int k = 0; k < 20; ++k) {
                const bool extreme = k % 4 == 0;
                std::vector<std::int32_t> heights = random_heights(
                    half_vertex_count(cells), extreme ? kLeast : -9, extreme ? kGreatest : 9, generator);
                // One vertex alone decides: each has its turn.
                heights[generator() % heights.size()] = extreme ? kGreatest : 1000;
                const WholeRange expected = plain_range(heights, cells), got = whole_range(heights, cells);
                ASSERT_EQ(got.least, expected.least);
                ASSERT_EQ(got.greatest, expected.greatest);
                ASSERT_EQ(got.in_triangle, expected.in_triangle) << cells << " cells";
            }
    }
}

TEST(HalfKernel, TransposesAHalf) {
    std::mt19937 generator(12);
    for (const std::int64_t target : vector_targets()) {
        const OneVectorTarget one(target);
        for (const int cells : {4, 8, 16, 32, 64, 128}) {
            const int n = cells + 1;
            const std::vector<std::int32_t> half =
                random_heights(half_vertex_count(cells), kLeast, kGreatest, generator);
            std::vector<std::int32_t> out(static_cast<std::size_t>(n * n), 7);
            transpose_half(half, cells, out.data());
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j)
                    ASSERT_EQ(out[static_cast<std::size_t>(i * n + j)],
                              i <= j ? half[half_vertex_index(j, i)] : 7);
        }
    }
}

// Rows that start at corners and middles of the parent's refined grid, in every direction that stays inside.
TEST(HalfKernel, GathersRows) {
    std::mt19937 generator(13);
    for (const std::int64_t target : vector_targets()) {
        const OneVectorTarget one(target);
        for (const int cells : {4, 8, 16, 32, 64, 128}) {
            const int n = cells + 1;
            const std::vector<std::int32_t> v = random_heights(static_cast<std::size_t>(n * n), 0, 1 << 20,
                                                               generator),
                                            c = random_heights(static_cast<std::size_t>(cells * cells), 0,
                                                               1 << 20, generator);
            int maps = 0;
            for (int k = 0; k < 9 * 16; ++k) {
                const auto step = [&](int bit) { return (k >> bit & 1) != 0 ? 1 : -1; };
                const RowMap m{k / 16 / 3 * cells, k / 16 % 3 * cells, step(0), step(1), step(2), step(3)};
                const auto inside = [&](int x) { return x >= 0 && x <= 2 * cells; };
                // Corners of the half, and even and odd places in turn.
                if (!inside(m.p0 + cells * m.p_row) || !inside(m.q0 + cells * m.q_row) ||
                    !inside(m.p0 + cells * (m.p_row + m.p_along)) ||
                    !inside(m.q0 + cells * (m.q_row + m.q_along)) || (m.p0 + m.q0) % 2 != 0)
                    continue;
                ++maps;
                std::vector<std::int32_t> out(half_vertex_count(cells));
                gather_rows(v.data(), c.data(), m, cells, out.data());
                for (int r = 0; r <= cells; ++r)
                    for (int s = 0; s <= r; ++s) {
                        const int p = m.p0 + r * m.p_row + s * m.p_along,
                                  q = m.q0 + r * m.q_row + s * m.q_along;
                        const auto at = [&](int width) {
                            return static_cast<std::size_t>(p / 2 * width + q / 2);
                        };
                        ASSERT_EQ(out[half_vertex_index(r, s)], p % 2 == 0 ? v[at(n)] : c[at(cells)]);
                    }
            }
            EXPECT_GE(maps, 8);
        }
    }
}

TEST(HalfKernel, NormalsAndGroundAreTheScalarOnes) {
    std::mt19937 generator(14);
    std::uniform_real_distribution<double> unit(-1, 1);
    const Ellipsoid body = Ellipsoid::mars();
    for (const std::int64_t target : vector_targets()) {
        const OneVectorTarget one(target);
        Places w{}, normals{}, ground{};
        for (auto& axis : w)
            for (double& x : axis) x = unit(generator);
        normals_and_ground(body, w, normals, ground);
        for (std::size_t k = 0; k < 16; ++k) {
            const Vec3 n = direction_from_tangents({w[0][k], w[1][k], w[2][k]}), p = body.position(n, 0);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                ASSERT_EQ(normals[axis][k], n[axis]);
                ASSERT_EQ(ground[axis][k], p[axis]);
            }
        }
    }
}

}  // namespace
}  // namespace carat::test
