// Clip positions against double precision: an eye that creeps along the ground sees vertices move smoothly.
#include <cmath>
#include <cstring>
#include <numbers>

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

// The eye one metre above the ground moves sideways in steps of 0.1 mm. Where a vertex within 10 m is drawn,
// against where double precision has it for that eye: sideways, up and forward it moves by the step to within
// 25.7 micrometres (the eye is rounded to whole units of 7.6 micrometres, before and after), and
// it lies within 6.2 micrometres of its place from the rounded eye.
TEST_F(ClipPosition, NoJitterOneMetreAboveTheGround) {
    Renderer& gpu = renderer(body, kCells);
    const double unit = length_unit(body);
    constexpr double kStep = 1e-4, kNear = 10;
    // Six roundings to float at 2^-24 of the distance (docs/accuracy.md); the eye's by half a unit a
    // component.
    constexpr double kPlace = 6 * std::numbers::sqrt3 * 0x1p-24 * kNear;
    const double jitter = 2 * kPlace + std::numbers::sqrt3 * unit;
    double uneven = 0, off = 0;
    std::uint64_t measured = 0;
    for (const Geodetic place : kPlaces) {
        const auto mesh = mesh_at(place, 34);  // about 1 m between vertices
        DrawRequest request;
        request.camera = look_down(body, place, body.a(), 1000, 1000, 90, 60, 0);
        const Camera& c = request.camera;
        const Vec3 start = body.position(direction(place), 8001);
        std::vector<std::array<float, 4>> before;
        for (int step = 0; step <= 50; ++step) {
            request.camera.eye = to_units(sum(start, scaled(kStep * step, c.right)), unit);
            auto clip = gpu.clip_positions(request, mesh);
            for (std::size_t v = 0; v < clip.size() && step > 0; ++v) {
                const Vec3 p = relative(*mesh, v, c);
                if (dot(p, p) > kNear * kNear) continue;
                ++measured;
                // 90 degrees: clip units are metres.
                const std::array<double, 3> exact{dot(c.right, p), -dot(c.up, p), dot(c.forward, p)},
                    step_of{-kStep, 0, 0}, now{clip[v][0], clip[v][1], clip[v][3]},
                    then{before[v][0], before[v][1], before[v][3]};
                for (std::size_t k = 0; k < 3; ++k) {
                    uneven = std::max(uneven, std::abs(now[k] - then[k] - step_of[k]));
                    off = std::max(off, std::abs(now[k] - exact[k]));
                }
            }
            before = std::move(clip);
        }
    }
    std::printf("%llu vertices: uneven by %.1f micrometres, off by %.1f\n",
                static_cast<unsigned long long>(measured), 1e6 * uneven, 1e6 * off);
    EXPECT_LE(jitter, 25.7e-6);
    EXPECT_LE(uneven, jitter);
    EXPECT_LE(off, kPlace);
    EXPECT_GT(uneven, unit / 2) << "the eye does move in whole units";
    EXPECT_GT(measured, 20'000u);
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
