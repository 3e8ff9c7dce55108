// Patches: positions bit for bit, watertight by identical integers, normals that agree.
#include <gtest/gtest.h>

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

// The fast way to a position is the slow way, to the last bit, on every vector unit that the processor has
// and without one; and the slow way is the ellipsoid's, up to rounding.
TEST(PatchBuilder, PositionsAreTheOneFunctionOfPointAndHeight) {
    std::mt19937_64 generator(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    const std::array<Ellipsoid, 2> bodies{Ellipsoid::earth(), Ellipsoid::moon()};
    const std::vector<std::int64_t> targets = vector_targets();
    double furthest = 0;
    for (int k = 0; k < 600; ++k) {
        const OneVectorTarget target(targets[static_cast<std::size_t>(k) % targets.size()]);
        const Ellipsoid& body = bodies[k % 2];
        const int cells = 4 << (k % 4);
        Vec3 n{unit(generator), unit(generator), unit(generator)};
        if (k % 5 == 0) n[0] = n[1];  // cube edges
        if (k % 25 == 0) n[2] = n[1];
        const Half half = locate(lattice_position(n), k % 51).half;
        HalfHeights heights;
        for (std::uint32_t v = 0; v < half_vertex_count(cells); ++v)
            if (k % 3 == 0)
                heights.whole.push_back(static_cast<std::int32_t>(unit(generator) * 3e6));
            else
                heights.fine.push_back(static_cast<std::int64_t>(unit(generator) * 3e6 / kHeightFraction));
        const double quantum = 1.0 / 512;
        const std::shared_ptr<PatchMesh> patch = PatchBuilder(body, quantum, cells).build(half, heights);
        ASSERT_EQ(patch->vertices.size(), heights.size());
        std::size_t v = 0;
        for (int r = 0; r <= cells; ++r)
            for (int c = 0; c <= r; ++c, ++v) {
                const LatticePoint p = lattice_vertex(half, cells, r, c);
                const double height = static_cast<double>(heights.at(v)) * (quantum * kHeightFraction);
                const UnitVector expected = vertex_position(body, p, height, length_unit(body));
                const Vec3 exact = body.position(direction(p), height);
                const PatchVertex& vertex = patch->vertices[v];
                for (std::size_t axis = 0; axis < 3; ++axis)
                    ASSERT_EQ(patch->anchor[axis] + vertex.offset[axis], expected[axis]);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    furthest = std::max(furthest, std::abs(exact[axis] / length_unit(body) -
                                                           static_cast<double>(expected[axis])) -
                                                      0.5);
                ASSERT_EQ(vertex.height, static_cast<float>(height));
            }
    }
    EXPECT_LT(furthest, kPositionRounding);
    std::printf("vertices are within 0.5 + %.4f units of the ellipsoid's positions\n", furthest);
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
