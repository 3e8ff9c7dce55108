// Patches: positions bit for bit, watertight by identical integers, normals that agree.
#include <gtest/gtest.h>

#include <random>

#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/octahedral.hpp"
#include "carat/render/patch_builder.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

// The fast way to a position is the slow way, to the last bit.
TEST(PatchBuilder, PositionsAreTheOneFunctionOfPointAndHeight) {
    std::mt19937_64 generator(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    const std::array<Ellipsoid, 2> bodies{Ellipsoid::earth(), Ellipsoid::moon()};
    for (int k = 0; k < 600; ++k) {
        const Ellipsoid& body = bodies[k % 2];
        const int cells = 4 << (k % 4);
        Vec3 n{unit(generator), unit(generator), unit(generator)};
        if (k % 5 == 0) n[0] = n[1];  // cube edges
        if (k % 25 == 0) n[2] = n[1];
        const Half half = locate(lattice_position(n), k % 51).half;
        HalfHeights heights;
        for (std::uint32_t v = 0; v < half_vertex_count(cells); ++v)
            heights.push_back(static_cast<std::int64_t>(unit(generator) * 3e6 / kHeightFraction));
        const double quantum = 1.0 / 512;
        const std::shared_ptr<PatchMesh> patch = PatchBuilder(body, quantum, cells).build(half, heights);
        ASSERT_EQ(patch->vertices.size(), heights.size());
        std::size_t v = 0;
        for (int r = 0; r <= cells; ++r)
            for (int c = 0; c <= r; ++c, ++v) {
                const LatticePoint p = lattice_vertex(half, cells, r, c);
                const double height = static_cast<double>(heights[v]) * (quantum * kHeightFraction);
                const UnitVector expected = to_units(body.position(direction(p), height), length_unit(body));
                const PatchVertex& vertex = patch->vertices[v];
                for (std::size_t axis = 0; axis < 3; ++axis)
                    ASSERT_EQ(patch->anchor[axis] + vertex.offset[axis], expected[axis]);
                ASSERT_EQ(vertex.height, static_cast<float>(height));
            }
    }
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
