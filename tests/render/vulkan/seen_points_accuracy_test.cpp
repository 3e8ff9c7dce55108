// Points behind pixels: against a ray caster in long double, and at vertices against the file's own heights.
#include <cmath>
#include <numbers>

#include "carat/codec/surface.hpp"
#include "carat/globe/globe.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/vertex_position.hpp"
#include "carat/vulkan/seen_points.hpp"
#include "mini_builder.hpp"
#include "planet.hpp"

namespace carat::test {
namespace {

using Real = long double;
using Vec = std::array<Real, 3>;

Real dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// What each pixel's ray meets first, and how sure that is.
class RayCaster {
  public:
    // A hit counts as certain if no edge passes closer to the pixel's centre than this: a device snaps
    // vertices to 1/256 pixel.
    static constexpr Real kMargin = 0.02L;

    RayCaster(const Camera& camera, double unit)
        : camera_(camera),
          unit_(unit),
          focal_(camera.height / (2 * std::tan(static_cast<Real>(camera.vertical_fov) / 2))),
          hits_(static_cast<std::size_t>(camera.width * camera.height)) {}

    void add(const PatchMesh& mesh, int cells) {
        for (const auto& corners : half_triangles(mesh.half.side, cells)) {
            std::array<Vec, 3> at;
            for (std::size_t k = 0; k < 3; ++k)
                for (std::size_t c = 0; c < 3; ++c)
                    at[k][c] = static_cast<Real>(mesh.anchor[c] - camera_.eye[c] +
                                                 mesh.vertices[corners[k]].offset[c]) *
                               static_cast<Real>(unit_);
            add(at);
        }
    }

    std::optional<Vec> certain(std::size_t pixel) const {
        const Hit& hit = hits_[pixel];
        if (!std::isfinite(hit.depth) || !(hit.depth * (1 + 1e-6L) < hit.doubtful)) return std::nullopt;
        return hit.point;
    }

  private:
    struct Hit {
        Real depth = INFINITY, doubtful = INFINITY;
        Vec point{};
    };

    Vec in_camera(const Vec& p) const {
        Vec out{};
        for (std::size_t c = 0; c < 3; ++c) {
            out[0] += p[c] * static_cast<Real>(camera_.right[c]);
            out[1] += p[c] * static_cast<Real>(camera_.up[c]);
            out[2] += p[c] * static_cast<Real>(camera_.forward[c]);
        }
        return out;
    }

    void add(const std::array<Vec, 3>& at) {
        std::array<std::array<Real, 2>, 3> screen;
        Real low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec v = in_camera(at[k]);
            if (!(v[2] > 0)) return;
            screen[k] = {camera_.width / 2.0L + focal_ * v[0] / v[2],
                         camera_.height / 2.0L - focal_ * v[1] / v[2]};
            for (std::size_t c = 0; c < 2; ++c) {
                low[c] = std::min(low[c], screen[k][c]);
                high[c] = std::max(high[c], screen[k][c]);
            }
        }
        const int size[2] = {camera_.width, camera_.height};
        int first[2], last[2];
        for (int c = 0; c < 2; ++c) {
            first[c] = static_cast<int>(std::max(0.0L, std::floor(low[c] - 1)));
            last[c] = static_cast<int>(std::min<Real>(size[c] - 1, std::ceil(high[c] + 1)));
        }
        for (int y = first[1]; y <= last[1]; ++y)
            for (int x = first[0]; x <= last[0]; ++x) meet(at, screen, x, y);
    }

    void meet(const std::array<Vec, 3>& at, const std::array<std::array<Real, 2>, 3>& screen, int x, int y) {
        Real margin = INFINITY;  // to the nearest edge, positive inside; fronts are clockwise with y down
        for (std::size_t k = 0; k < 3; ++k) {
            const auto &a = screen[k], &b = screen[(k + 1) % 3];
            const Real ex = b[0] - a[0], ey = b[1] - a[1];
            margin = std::min(margin, (ey * (x + 0.5L - a[0]) - ex * (y + 0.5L - a[1])) / std::hypot(ex, ey));
        }
        if (margin < -kMargin) return;
        Vec ray{};
        const Real right = (x + 0.5L - camera_.width / 2.0L) / focal_;
        const Real up = (camera_.height / 2.0L - (y + 0.5L)) / focal_;
        for (std::size_t c = 0; c < 3; ++c)
            ray[c] = camera_.forward[c] + right * camera_.right[c] + up * camera_.up[c];
        Vec e{}, f{}, normal{};
        for (std::size_t c = 0; c < 3; ++c) {
            e[c] = at[1][c] - at[0][c];
            f[c] = at[2][c] - at[0][c];
        }
        for (std::size_t c = 0; c < 3; ++c)
            normal[c] = e[(c + 1) % 3] * f[(c + 2) % 3] - e[(c + 2) % 3] * f[(c + 1) % 3];
        const Real depth = dot(normal, at[0]) / dot(normal, ray);
        Hit& hit = hits_[static_cast<std::size_t>(y * camera_.width + x)];
        if (margin <= kMargin) {
            hit.doubtful = std::min(hit.doubtful, depth);
        } else if (depth < hit.depth) {
            hit.depth = depth;
            for (std::size_t c = 0; c < 3; ++c) hit.point[c] = depth * ray[c];
        }
    }

    const Camera& camera_;
    double unit_;
    Real focal_;
    std::vector<Hit> hits_;
};

class SeenPoints : public RendererTest {};

double ridges(const Vec3& n) {
    return 900 * std::sin(700 * n[0]) * std::cos(500 * n[1]) + 60 * std::sin(3e4 * n[2] + 2e4 * n[1]);
}

TEST_F(SeenPoints, AgreeWithALongDoubleRayCasterAtAnyDistance) {
    const Ellipsoid body = Ellipsoid::earth();
    constexpr int kCells = 64, kWidth = 192, kHeight = 128;
    std::mt19937 random(5);
    const auto halves = random_cut(18, 1, random);
    const auto deepest = std::max_element(halves.begin(), halves.end(), [](const Half& a, const Half& b) {
        return a.diamond.level() < b.diamond.level();
    });
    const Geodetic place = geodetic(direction(half_frame(*deepest, 4).vertex(2, 2)));
    const Patches patches = make_meshes(body, halves, kCells, ridges);
    Renderer& gpu = renderer(body, kCells);
    struct Sight {
        double altitude, tilt;
    };
    for (const Sight sight : {Sight{8000, 35}, Sight{1e6, 30}, Sight{3e7, 3}}) {
        SCOPED_TRACE(sight.altitude);
        DrawRequest request;
        request.camera =
            look_down(body, place, body.a() + sight.altitude, kWidth, kHeight, 25, sight.tilt, 5);
        request.aovs.patch = true;
        const Frame frame = gpu.draw(request, patches);
        const auto points = seen_points(frame, request.camera, length_unit(body), kCells, patches);
        RayCaster caster(request.camera, length_unit(body));
        for (const auto& mesh : patches) caster.add(*mesh, kCells);
        int seen = 0, certain = 0;
        Real worst = 0;
        double off = 0;
        for (std::size_t k = 0; k < points.size(); ++k) {
            if (frame.patch[k] == kNoPatch) {
                EXPECT_EQ(points[k].position, (Vec3{0, 0, 0}));
                EXPECT_FALSE(caster.certain(k).has_value()) << k;
                continue;
            }
            ++seen;
            const auto pixel = project(request.camera, points[k].position);
            off = std::max({off, std::abs(pixel[0] - (static_cast<double>(k % kWidth) + 0.5)),
                            std::abs(pixel[1] - (static_cast<double>(k / kWidth) + 0.5))});
            if (const auto truth = caster.certain(k)) {
                ++certain;
                for (std::size_t c = 0; c < 3; ++c)
                    worst = std::max(worst, std::abs((*truth)[c] - static_cast<Real>(points[k].position[c])));
            }
        }
        std::printf("%g m: %d pixels, %d certain, greatest difference %.2Lg m, off the pixel %.2g\n",
                    sight.altitude, seen, certain, worst, off);
        EXPECT_GT(seen, kWidth * kHeight / 10);
        EXPECT_GT(certain, 0.4 * seen);  // from afar most pixels hold an edge
        EXPECT_LE(worst, 1e-3L);
        EXPECT_LE(off, 0.01);
    }
}

// A camera at that distance from a point, looking at it along a ray tilted against the vertical.
Camera aimed_at(const Ellipsoid& body, const Vec3& point, const Vec3& normal, double distance, double tilt,
                double turn) {
    const Vec3 east = unit(test::cross(std::abs(normal[2]) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0}, normal));
    const Vec3 aside = sum(scaled(std::cos(turn), east), scaled(std::sin(turn), test::cross(normal, east)));
    const Vec3 away = sum(scaled(std::cos(tilt), normal), scaled(std::sin(tilt), aside));
    Camera camera;
    camera.eye = to_units(sum(point, scaled(distance, away)), length_unit(body));
    camera.forward = unit(sum(point, scaled(-1, to_metres(camera.eye, length_unit(body)))));
    camera.right =
        unit(test::cross(camera.forward, std::abs(camera.forward[2]) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0}));
    camera.up = test::cross(camera.right, camera.forward);
    camera.vertical_fov = 0.3;
    camera.width = camera.height = 3;
    return camera;
}

// The ray of the middle pixel passes through a sample of the file: there the height is the sample's own, at
// whatever level the surface is drawn (mode 0 keeps samples), and so is what a query says at that place.
TEST_F(SeenPoints, HeightsAtVerticesAreTheFilesOwn) {
    MiniPlan plan;
    plan.source = fractal(200000, 28);
    plan.depth = 7;
    const auto file = build_mini(plan).open();
    const Surface surface(file);
    const Ellipsoid body = plan.body;
    const int cells = 1 << plan.log2_cells;
    Renderer& gpu = renderer(body, cells);
    std::mt19937 random(2);
    std::uniform_int_distribution<int> index(2, cells - 2), turn(0, 359), deeper(1, 4);
    const auto halves = level_halves(4);
    int exact = 0;
    std::set<int> levels;
    for (int n = 0; n < 60; ++n) {
        const Half half = halves[static_cast<std::size_t>(n * 31) % halves.size()];
        const HalfFrame frame = half_frame(half, cells);
        int i = index(random), j = index(random);
        if ((half.side == 0) != (i >= j)) std::swap(i, j);
        const LatticePoint place = frame.vertex(i, j);
        const double height = surface.sample(lattice_position(direction(place))).height;
        const UnitVector vertex = vertex_position(body, place, height, length_unit(body));
        const double distance = std::pow(10.0, 4 + 3 * n / 60.0);
        const Camera camera = aimed_at(body, to_metres(vertex, length_unit(body)), direction(place), distance,
                                       0.6, turn(random));
        DrawRequest request;
        request.camera = camera;
        request.aovs.patch = true;
        const DrawList list = converged_cut(*file, View(camera, length_unit(body)), 0.01 * deeper(random));
        const Frame drawn = gpu.draw(request, list.meshes);
        ASSERT_NE(drawn.patch[4], kNoPatch);
        const int level = half_of_pixel(drawn.patch[4]).diamond.level();
        if (level < half.diamond.level()) continue;  // the vertex is not drawn
        levels.insert(level);
        const SeenPoint seen = seen_points(drawn, camera, length_unit(body), cells, list.meshes)[4];
        EXPECT_EQ(static_cast<float>(seen.height), static_cast<float>(height)) << n;
        const auto there = body.normal_height(sum(to_metres(camera.eye, length_unit(body)), seen.position));
        EXPECT_NEAR(surface.sample(lattice_position(direction(geodetic(there.normal)))).height, height, 1e-5)
            << n;
        ++exact;
    }
    EXPECT_GE(exact, 40);
    EXPECT_GE(levels.size(), 2u);
}

}  // namespace
}  // namespace carat::test
