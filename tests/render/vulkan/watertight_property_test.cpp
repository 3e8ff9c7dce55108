// No hole between patches: by pixels against a magenta background, and without pixels by comparing shared
// vertices.
#include <cmath>
#include <cstring>
#include <map>

#include "carat/globe/globe.hpp"
#include "planet.hpp"

namespace carat::test {

namespace {

constexpr unsigned kSeed = 20061;

double rough(const Vec3& n) {
    double h = 0;
    for (const double f : {3.0, 7.0, 17.0, 41.0, 97.0, 233.0}) {
        h += std::sin(f * n[0] + 1) * std::cos(f * n[1] - f) * std::sin(f * n[2] + 2 * f) / f;
    }
    return 20000 * h;
}
constexpr double kLowest = -20000 * 0.56;  // sum of 1/f

Camera random_camera(const Ellipsoid& body, std::mt19937& random, int width, int height) {
    std::uniform_real_distribution<double> share(0, 1);
    const double altitude = std::exp(std::log(3e4) + share(random) * std::log(1e3));  // 30 km to 30000 km
    const Geodetic above{std::asin(2 * share(random) - 1) * 57.29577951, 360 * share(random) - 180};
    const double limb = std::asin(body.a() / (body.a() + altitude)) * 57.29577951;
    return look_down(body, above, body.a() + altitude, width, height, 20 + 60 * share(random),
                     limb * share(random), 360 * share(random));
}

class Watertight : public RendererTest {
  protected:
    const Ellipsoid body = Ellipsoid::earth();
    std::mt19937 random{kSeed};
    void SetUp() override { RecordProperty("seed", static_cast<int>(kSeed)); }
};

// Random cuts of three bodies in three sizes, without regard to any threshold: neighbours of any levels.
// Files with their own cuts: carat bench watertight, tests/cli/bench_property_test.cpp.
TEST_F(Watertight, NoBackgroundBehindRaysThatHitTheLoweredEllipsoid) {
    constexpr int kCells = 16;
    struct Case {
        Ellipsoid body;
        int width, height;
    };
    std::uint64_t pixels = 0;
    for (const Case& c : {Case{Ellipsoid::earth(), 128, 128}, Case{Ellipsoid::moon(), 160, 90},
                          Case{Ellipsoid::mars(), 100, 144}}) {
        Renderer& gpu = renderer(c.body, kCells);
        DrawRequest request;
        request.background = {1, 0, 1};
        request.light.ambient = 1;
        const double size = c.body.a() / Ellipsoid::earth().a();
        for (int planet = 0; planet < 2; ++planet) {
            const Patches patches = make_meshes(c.body, random_cut(9, 12, random), kCells,
                                                [&](const Vec3& n) { return size * rough(n); });
            // Coarse triangles lie up to their sagitta below the lowest heights: 600 km cells at level 0.
            const double lowered = size * (kLowest - 8000);
            for (int shot = 0; shot < 34; ++shot) {
                request.camera = random_camera(c.body, random, c.width, c.height);
                const Frame frame = gpu.draw(request, patches);
                const Vec3 eye = eye_metres(c.body, request.camera);
                for (int y = 0; y < c.height; ++y) {
                    for (int x = 0; x < c.width; ++x) {
                        if (!hit(c.body, lowered, eye, ray(request.camera, x + 0.5, y + 0.5))) continue;
                        ++pixels;
                        ASSERT_EQ(frame.colour.at(x, y)[3], 1)
                            << "hole at " << x << ", " << y << ", " << c.body.name() << ", shot " << shot
                            << ", seed " << kSeed;
                    }
                }
            }
        }
    }
    EXPECT_GT(pixels, 1000000u);
}

TEST_F(Watertight, SharedVerticesHaveTheSameClipPositionInEveryPatch) {
    constexpr int kCells = 16;
    Renderer& gpu = renderer(body, kCells);
    const Patches patches = make_meshes(body, random_cut(12, 6, random), kCells, rough);
    DrawRequest request;
    std::size_t shared = 0;
    for (int shot = 0; shot < 2; ++shot) {
        request.camera = random_camera(body, random, 640, 480);
        std::map<UnitVector, std::array<float, 4>> seen;
        for (const auto& mesh : patches) {
            const auto clip = gpu.clip_positions(request, mesh);
            ASSERT_EQ(clip.size(), mesh->vertices.size());
            for (std::size_t v = 0; v < clip.size(); ++v) {
                UnitVector place;
                for (std::size_t k = 0; k < 3; ++k) place[k] = mesh->anchor[k] + mesh->vertices[v].offset[k];
                const auto [first, fresh] = seen.emplace(place, clip[v]);
                if (fresh) continue;
                ++shared;
                ASSERT_EQ(std::memcmp(&first->second, &clip[v], sizeof(clip[v])), 0) << "seed " << kSeed;
            }
        }
    }
    EXPECT_GT(shared, 1000u);
}

}  // namespace

}  // namespace carat::test
