// Patches: positions bit for bit, watertight by identical integers, normals that agree.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/octahedral.hpp"
#include "carat/render/patch_builder.hpp"
#include "carat/render/vertex_position.hpp"
#include "render/cut/support.hpp"
#include "render/cut/vector_target.hpp"

namespace carat::test {
namespace {

struct RandomHalf {
    const Ellipsoid& body;
    Half half;
    int cells;
    HalfHeights heights;
};

// Of any level, some on the edges and corners of the cube, with heights up to 100 km or 0.9 a.
RandomHalf random_half(const Ellipsoid& body, int k, double quantum, std::mt19937_64& generator) {
    std::uniform_real_distribution<double> unit(-1, 1);
    Vec3 n{unit(generator), unit(generator), unit(generator)};
    if (k % 5 == 0) n[0] = n[1];
    if (k % 25 == 0) n[2] = n[1];
    RandomHalf out{body, locate(lattice_position(n), k % 51).half, 4 << (k / 7 % 5), {}};
    const double highest = std::min(1e5, 0.9 * body.a()) / quantum;
    for (std::uint32_t v = 0; v < half_vertex_count(out.cells); ++v)
        if (k % 3 == 0)
            out.heights.whole.push_back(static_cast<std::int32_t>(unit(generator) * highest));
        else
            out.heights.fine.push_back(
                static_cast<std::int64_t>(unit(generator) * highest / kHeightFraction));
    return out;
}

// On every vector unit that the processor has and without one: the border, which patches share, is the one
// function of point and height to the last bit; what lies inside is the same on each, within rounding of the
// ellipsoid's positions, and so of the function.
TEST(PatchBuilder, PositionsAreTheFunctionOfPointAndHeight) {
    std::mt19937_64 generator(3);
    const std::array<Ellipsoid, 5> bodies{Ellipsoid::earth(), Ellipsoid::moon(),
                                          Ellipsoid(71'492'000, 66'854'000), Ellipsoid(1'000, 900),
                                          Ellipsoid(5'000'000, 1'000'000)};
    const std::vector<std::int64_t> targets = vector_targets();
    constexpr double kQuantum = 1.0 / 512;
    double furthest = 0;
    int fitted = 0;
    for (int k = 0; k < 1000; ++k) {
        const RandomHalf random =
            random_half(bodies[static_cast<std::size_t>(k) % bodies.size()], k, kQuantum, generator);
        const auto& [body, half, cells, heights] = random;
        const PatchBuilder builder(body, kQuantum, cells);
        std::shared_ptr<PatchMesh> patch;
        for (const std::int64_t target :
             {targets[0], targets[static_cast<std::size_t>(k) % targets.size()]}) {
            const OneVectorTarget one(target);
            const std::shared_ptr<PatchMesh> made = builder.build(half, heights);
            ASSERT_EQ(made->vertices.size(), heights.size());
            for (std::size_t v = 0; patch && v < heights.size(); ++v)
                ASSERT_EQ(made->vertices[v].offset, patch->vertices[v].offset);
            patch = made;
        }
        std::size_t v = 0;
        for (int r = 0; r <= cells; ++r)
            for (int c = 0; c <= r; ++c, ++v) {
                const LatticePoint p = lattice_vertex(half, cells, r, c);
                const double height = static_cast<double>(heights.at(v)) * (kQuantum * kHeightFraction);
                const UnitVector expected = vertex_position(body, p, height, length_unit(body));
                const Vec3 exact = body.position(direction(p), height);
                const PatchVertex& vertex = patch->vertices[v];
                ASSERT_EQ(vertex.height, static_cast<float>(height));
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const std::int64_t got = patch->anchor[axis] + vertex.offset[axis];
                    if (c == 0 || c == r || r == cells) {
                        ASSERT_EQ(got, expected[axis]);
                    }
                    fitted += got != expected[axis] ? 1 : 0;
                    furthest = std::max(
                        furthest, std::abs(exact[axis] / length_unit(body) - static_cast<double>(got)) - 0.5);
                }
            }
    }
    EXPECT_LT(furthest, kPositionRounding);
    EXPECT_GT(fitted, 0) << "no half has polynomials";
    std::printf(
        "vertices are within 0.5 + %.4f units of the ellipsoid's positions, %d coordinates inside rounded to "
        "the other side\n",
        furthest, fitted);
}

TEST(VertexTangent, IsTheTangent) {
    EXPECT_EQ(vertex_tangent(0), 0);
    EXPECT_EQ(vertex_tangent(1), 1);
    EXPECT_EQ(vertex_tangent(-1), -1);
    std::mt19937_64 generator(4);
    std::uniform_real_distribution<double> unit(0, 1);
    double worst = 0;
    for (int k = 0; k < 1'000'000; ++k) {
        const double x = unit(generator), t = vertex_tangent(x);
        ASSERT_EQ(vertex_tangent(-x), -t);
        const long double exact = std::tan(std::numbers::pi_v<long double> / 4 * x);
        worst = std::max(worst, static_cast<double>(std::abs(t - exact) / exact) * 0x1p53);
    }
    EXPECT_LT(worst, 4);  // half ulps at worst: 2 ulp
    // Increasing up to the ends.
    EXPECT_LT(vertex_tangent(std::nextafter(1.0, 0.0)), 1.0);
}

TEST(PatchBuilder, SharedVerticesAreIdenticalFromEveryPatch) {
    std::uint64_t shared = 0;
    for (const FakeRepository* repository : planets())
        for (const double threshold : {1.0, 6.0})
            for (const NamedView& v : test_views(*repository, 30, 2024)) {
                SCOPED_TRACE(v.name);
                shared += expect_watertight(converged_cut(*repository, v.view, threshold),
                                            repository->header().cells());
                ASSERT_FALSE(HasFailure());
            }
    EXPECT_GT(shared, 50000u);
}

double degrees(const Vec3& p, const Vec3& q) {
    const Vec3 c{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
    return std::atan2(norm(c), p[0] * q[0] + p[1] * q[1] + p[2] * q[2]) * 57.29577951308232;
}

// On a body without relief the normals are those of the ellipsoid, corners and edges included.
TEST(PatchBuilder, NormalsOfASmoothBodyAreGeodetic) {
    FakeOptions options;
    options.body = Ellipsoid(1e6, 9e5);
    options.log2_cells = 4;
    options.depth = 3;
    options.relief = [](const Vec3&) { return 0.0; };
    const FakeRepository repository(options);
    double worst_inside = 0, worst_boundary = 0;
    for (const NamedView& v : test_views(repository, 10, 1)) {
        SCOPED_TRACE(v.name);
        const DrawList list = converged_cut(repository, v.view, 4.0);
        // Vertices on the rim of what is drawn see triangles on one side only; they are off screen or behind
        // the horizon. Elsewhere a normal is off by less than the angle of a cell.
        for (const auto& mesh : list.meshes) {
            const int level = mesh->half.diamond.level();
            const double cell = 90.0 / 16 / std::sqrt(std::ldexp(1.0, level));  // degrees
            std::size_t k = 0;
            for (int r = 0; r <= 16; ++r)
                for (int c = 0; c <= r; ++c, ++k) {
                    const double off = degrees(decode_octahedral(mesh->vertices[k].normal),
                                               direction(lattice_vertex(mesh->half, 16, r, c)));
                    const bool inside = c > 0 && c < r && r < 16;
                    ASSERT_LT(off, (inside ? 0.15 : 1.5) * cell + 0.01);
                    (inside ? worst_inside : worst_boundary) =
                        std::max(inside ? worst_inside : worst_boundary, (off - 0.005) / cell);
                }
        }
    }
    std::printf("off by at most %.3f cells inside, %.3f on boundaries\n", worst_inside, worst_boundary);
}

}  // namespace
}  // namespace carat::test
