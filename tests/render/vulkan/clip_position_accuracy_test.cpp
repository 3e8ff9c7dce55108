// Clip positions against double precision: an eye that creeps along the ground sees vertices move smoothly.
#include <cmath>
#include <cstring>

#include "carat/bench/shader_arithmetic.hpp"
#include "carat/globe/globe.hpp"
#include "planet.hpp"

namespace carat::test {

namespace {

class ClipPosition : public RendererTest {
  protected:
    const Ellipsoid body = Ellipsoid::earth();
    static constexpr int kCells = 64;

    // A half around a place, 5 mm to 600 km between vertices.
    std::shared_ptr<const PatchMesh> mesh_at(Geodetic place, int level) const {
        return make_mesh(body, locate(lattice_position(direction(place)), level).half, kCells,
                         [](const Vec3&) { return 8000.0; });
    }
    Vec3 relative(const PatchMesh& mesh, std::size_t v, const Camera& camera) const {
        UnitVector d;
        for (std::size_t k = 0; k < 3; ++k)
            d[k] = mesh.anchor[k] + mesh.vertices[v].offset[k] - camera.eye[k];
        return to_metres(d, length_unit(body));
    }
};

const Geodetic kPlaces[] = {{0, 0}, {90, 0}, {-90, 0}, {35.26438968, 45}, {-27.5, 180}, {46.5, 8.0}, {0, 45}};

// At a distance of d metres the drawn vertex is off by at most 4 roundings to float: 4 * 2^-24 * d * sqrt(3).
TEST_F(ClipPosition, WithinFloatPrecisionOfTheDistance) {
    Renderer& gpu = renderer(body, kCells);
    for (const Geodetic place : kPlaces) {
        for (const int level : {0, 10, 20, 30, 40}) {
            const auto mesh = mesh_at(place, level);
            for (const double altitude : {8000.5, 8010.0, 1e5, 1e8}) {
                DrawRequest request;
                request.camera = look_down(body, place, body.a() + altitude, 1000, 1000, 90, 30, 12);
                request.camera.eye = to_units(body.position(direction(place), altitude), length_unit(body));
                const auto clip = gpu.clip_positions(request, mesh);
                for (std::size_t v = 0; v < clip.size(); v += 7) {
                    const Vec3 p = relative(*mesh, v, request.camera);
                    const double bound = 4 * 1.7321 * 0x1p-24 * std::sqrt(dot(p, p));
                    ASSERT_NEAR(clip[v][3], dot(request.camera.forward, p), bound);
                    ASSERT_NEAR(clip[v][0], dot(request.camera.right, p), bound);
                    ASSERT_NEAR(clip[v][1], -dot(request.camera.up, p), bound);
                }
            }
        }
    }
}

// The eye one metre above the ground moves sideways in steps of 0.1 mm: vertices 10 m away move against the
// eye by the same step, to within 5 micrometres.
TEST_F(ClipPosition, NoJitterOneMetreAboveTheGround) {
    Renderer& gpu = renderer(body, kCells);
    constexpr double kStep = 1e-4, kBound = 5e-6;
    double worst = 0;
    for (const Geodetic place : kPlaces) {
        const auto mesh = mesh_at(place, 34);  // about 1 m between vertices
        DrawRequest request;
        request.camera = look_down(body, place, body.a(), 1000, 1000, 90, 60, 0);
        const Vec3 start = body.position(direction(place), 8001);
        std::vector<std::array<float, 4>> before;
        for (int step = 0; step <= 50; ++step) {
            request.camera.eye =
                to_units(sum(start, scaled(kStep * step, request.camera.right)), length_unit(body));
            auto clip = gpu.clip_positions(request, mesh);
            for (std::size_t v = 0; v < clip.size() && step > 0; ++v) {
                const Vec3 p = relative(*mesh, v, request.camera);
                if (dot(p, p) > 100) continue;
                const double moved = before[v][0] - clip[v][0];  // 90 degrees: clip units are metres
                // The eye itself moves in whole length units of 7.6 micrometres.
                worst = std::max(worst, std::abs(moved - kStep) - length_unit(body));
            }
            before = std::move(clip);
        }
    }
    RecordProperty("worst_micrometres", std::to_string(worst * 1e6));
    EXPECT_LE(worst, kBound);
    EXPECT_GT(worst, -length_unit(body)) << "nothing was measured";
}

// Depth as the device stores it keeps 1 cm apart at 10 m, and orders vertices as their distance does.
TEST_F(ClipPosition, DepthResolvesACentimetreAtTenMetres) {
    Renderer& gpu = renderer(body, kCells);
    const auto mesh = mesh_at({46.5, 8.0}, 40);
    DrawRequest request;
    request.camera = look_down(body, {46.5, 8.0}, body.a(), 1000, 1000, 90);
    for (const double altitude : {8000.5, 8010.0, 8100.0}) {
        request.camera.eye =
            to_units(body.position(direction(Geodetic{46.5, 8.0}), altitude), length_unit(body));
        const auto clip = gpu.clip_positions(request, mesh);
        const double w = clip[0][3], near_plane = clip[0][2];
        const float depth = static_cast<float>(near_plane / w);
        const double next = near_plane / std::nextafter(depth, 0.0f);
        EXPECT_LT(next - w, 1e-3 * w) << altitude;
        EXPECT_NE(depth, static_cast<float>(near_plane / (w * 1.001))) << altitude;
    }
}

// carat bench stability sweeps what the shader computes without a GPU: the same bits.
TEST_F(ClipPosition, TheArithmeticOfTheBenchIsTheShaders) {
    Renderer& gpu = renderer(body, kCells);
    std::size_t compared = 0;
    for (const Geodetic place : kPlaces)
        for (const int level : {0, 14, 27, 40}) {
            const auto mesh = mesh_at(place, level);
            for (const double altitude : {8000.5, 8100.0, 1e7}) {
                DrawRequest request;
                request.camera = look_down(body, place, body.a(), 1000, 1000, 90, 50, 21);
                request.camera.eye = to_units(body.position(direction(place), altitude), length_unit(body));
                const bench::ShaderCamera shader(request.camera, length_unit(body));
                const float scale = static_cast<float>(1 / std::tan(request.camera.vertical_fov / 2));
                const auto clip = gpu.clip_positions(request, mesh);
                for (std::size_t v = 0; v < clip.size(); ++v) {
                    UnitVector vertex;
                    for (std::size_t k = 0; k < 3; ++k)
                        vertex[k] = mesh->anchor[k] + mesh->vertices[v].offset[k];
                    const auto p = bench::shader_position(shader, vertex);
                    const std::array<float, 3> expected{p[0] * scale, -p[1] * scale, p[2]},
                        found{clip[v][0], clip[v][1], clip[v][3]};
                    ASSERT_EQ(std::memcmp(&expected, &found, sizeof(found)), 0) << level << ", vertex " << v;
                    ++compared;
                }
            }
        }
    EXPECT_GT(compared, 10000u);
}

}  // namespace

}  // namespace carat::test
