// Patches that face away: the picture is the same without them, and the work is less.
#include <algorithm>
#include <cmath>

#include "back_faces.hpp"
#include "carat/globe/globe.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/octahedral.hpp"
#include "planet.hpp"

namespace carat::test {
namespace {

constexpr int kCells = 16;

double hilly(const Vec3& n) {
    return 30000 * std::sin(40 * n[0] + 1) * std::cos(37 * n[1]) + 9000 * std::sin(90 * n[2] + 2);
}

class BackFaceTest : public RendererTest {
  protected:
    const Ellipsoid body = Ellipsoid::earth();
    std::mt19937 random{20063};
};

// No triangle of a patch that is said to face away does face the eye.
TEST_F(BackFaceTest, EveryTriangleOfAPatchSaidToFaceAwayDoes) {
    const double unit_length = length_unit(body);
    const Patches patches = make_meshes(body, random_cut(10, 10, random), kCells, hilly);
    std::uniform_real_distribution<double> share(0, 1);
    std::normal_distribution<double> gauss;
    std::uint64_t away = 0, facing = 0;
    for (int k = 0; k < 20; ++k) {
        const Vec3 n = unit({gauss(random), gauss(random), gauss(random)});
        const Vec3 eye = body.position(n, 5e4 * std::exp(share(random) * std::log(1e3)));
        for (const auto& mesh : patches) {
            const TriangleCone cone = triangle_cone(*mesh, kCells, unit_length);
            const Vec3 from_anchor = sum(eye, scaled(-1, to_metres(mesh->anchor, unit_length)));
            if (!faces_away(cone, from_anchor)) {
                ++facing;
                continue;
            }
            ++away;
            for (const auto& corners : half_triangles(mesh->half.side, kCells)) {
                const auto at = [&](std::size_t c) {
                    return to_metres(mesh->vertices[corners[c]].offset, unit_length);
                };
                const Vec3 a = at(0),
                           normal = unit(cross(sum(at(1), scaled(-1, a)), sum(at(2), scaled(-1, a))));
                ASSERT_LT(dot(normal, unit(sum(from_anchor, scaled(-1, a)))), 0);
            }
        }
    }
    EXPECT_GT(away, 500u);
    EXPECT_GT(facing, 500u);
}

TEST_F(BackFaceTest, ThePictureIsTheSameBitForBitAndTheWorkLess) {
    Renderer& gpu = renderer(body, kCells);
    const Patches patches = make_meshes(body, random_cut(10, 10, random), kCells, hilly);
    std::uint64_t left_out = 0;
    for (int shot = 0; shot < 12; ++shot) {
        DrawRequest request;
        const double altitude = 6e4 * std::pow(2.0, shot);
        request.camera =
            look_down(body, {7.0 * shot - 40, 31.0 * shot}, body.a() + altitude, 160, 120, 50, 4.0 * shot);
        request.background = {1, 0, 1};
        request.aovs.depth = request.aovs.normal = request.aovs.patch = true;
        const Frame all = gpu.draw(request, patches);
        EXPECT_EQ(all.counters.patches_back, 0u);
        EXPECT_EQ(all.counters.patches_drawn, patches.size());
        request.skip_back_patches = true;
        Frame some = gpu.draw(request, patches);
        EXPECT_EQ(some.counters.patches_drawn + some.counters.patches_back, patches.size());
        EXPECT_EQ(some.counters.triangles, some.counters.patches_drawn * kCells * kCells);
        left_out += some.counters.patches_back;
        EXPECT_EQ(some.colour.values, all.colour.values) << shot;
        EXPECT_EQ(some.depth.values, all.depth.values) << shot;
        EXPECT_EQ(some.normal.values, all.normal.values) << shot;
        EXPECT_EQ(some.patch, all.patch) << shot;
    }
    EXPECT_GT(left_out, 100u);
}

// Without culling of triangles the backs are wanted.
TEST_F(BackFaceTest, BacksAreDrawnWhereTheyAreNotCulled) {
    Renderer& gpu = renderer(body, kCells);
    const Patches patches = make_meshes(body, level_halves(3), kCells, hilly);
    DrawRequest request;
    request.camera = look_down(body, {10, 20}, 2 * body.a(), 64, 64, 60);
    request.skip_back_patches = true;
    EXPECT_GT(gpu.draw(request, patches).counters.patches_back, 0u);
    request.cull_back_faces = false;
    EXPECT_EQ(gpu.draw(request, patches).counters.patches_drawn, patches.size());
}

// A few are judged a frame, and all in the end; a new mesh of the same half is judged anew.
TEST_F(BackFaceTest, ConesAreMadeAFewAFrame) {
    const double unit_length = length_unit(body);
    const Patches patches = make_meshes(body, level_halves(5), kCells, [](const Vec3&) { return 0.0; });
    BackFaces judge(kCells, unit_length);
    const UnitVector eye = to_units(body.position({1, 0, 0}, 1e7), unit_length);
    const auto count = [&] {
        judge.begin();
        return std::count_if(patches.begin(), patches.end(),
                             [&](const auto& m) { return judge.faces_away(m, eye); });
    };
    const auto first = count();
    EXPECT_LE(first, BackFaces::kConesAFrame);
    auto last = first;
    for (int k = 0; k < 20; ++k) last = count();
    EXPECT_GT(last, first);
    EXPECT_GT(last, static_cast<std::ptrdiff_t>(patches.size() / 3)) << "the far side";

    const auto flipped = std::make_shared<PatchMesh>(*patches.front());
    for (PatchVertex& v : flipped->vertices) v.normal = encode_octahedral({1, 0, 0});
    judge.begin();
    EXPECT_FALSE(judge.faces_away(flipped, to_units({1e9, 0, 0}, unit_length)));
}

}  // namespace
}  // namespace carat::test
