// The sky against an integration of single scattering that shares no code with the shaders: no tables,
// hundreds of steps, a sphere. And what may be seen of water.
#include <cmath>

#include "carat/globe/error.hpp"
#include "carat/globe/globe.hpp"
#include "planet.hpp"

namespace carat::test {

namespace {

constexpr double kPi = 3.14159265358979323846;

using Rgb = std::array<double, 3>;

class SingleScattering {
  public:
    SingleScattering(const Atmosphere& air, double ground) : air_(air), ground_(ground) {}

    // Along a ray from `from` to `length` metres away, the sun's irradiance above the air being 1.
    Rgb radiance(const Vec3& from, const Vec3& way, double length, const Vec3& sun) const {
        const double c = dot(way, sun), g = air_.mie_asymmetry;
        const double rayleigh = 3 / (16 * kPi) * (1 + c * c);
        const double mie =
            3 / (8 * kPi) * (1 - g * g) * (1 + c * c) / ((2 + g * g) * std::pow(1 + g * g - 2 * g * c, 1.5));
        Rgb depth{}, out{};
        const int steps = 600;
        for (int i = 0; i < steps; ++i) {
            const double step = length / steps;
            const Vec3 p = sum(from, scaled((i + 0.5) * step, way));
            const double h = height(p);
            const Rgb sunlight = shadowed(p, sun) ? Rgb{0, 0, 0} : transmittance(p, sun);
            for (std::size_t k = 0; k < 3; ++k) {
                const double half = 0.5 * extinction(h, k) * step;
                const double scattered = air_.rayleigh[k] * std::exp(-h / air_.rayleigh_height) * rayleigh +
                                         air_.mie_scattering[k] * std::exp(-h / air_.mie_height) * mie;
                out[k] += std::exp(-depth[k] - half) * sunlight[k] * scattered * step;
                depth[k] += 2 * half;
            }
        }
        return out;
    }

    Rgb transmittance(const Vec3& from, const Vec3& way) const {
        const double length = to_top(from, way);
        Rgb depth{};
        const int steps = 300;
        for (int i = 0; i < steps; ++i) {
            const double h = height(sum(from, scaled((i + 0.5) * length / steps, way)));
            for (std::size_t k = 0; k < 3; ++k) depth[k] += extinction(h, k) * length / steps;
        }
        return {std::exp(-depth[0]), std::exp(-depth[1]), std::exp(-depth[2])};
    }

    double to_top(const Vec3& from, const Vec3& way) const {
        const double b = dot(from, way), r = ground_ + air_.top;
        return -b + std::sqrt(b * b - dot(from, from) + r * r);
    }

  private:
    double height(const Vec3& p) const { return std::max(std::sqrt(dot(p, p)) - ground_, 0.0); }
    bool shadowed(const Vec3& p, const Vec3& sun) const {
        const double b = dot(p, sun);
        return b < 0 && dot(p, p) - b * b < ground_ * ground_;
    }
    double extinction(double h, std::size_t k) const {
        const double layer =
            std::max(0.0, 1 - std::abs(h - air_.absorption_middle) / air_.absorption_half_width);
        return air_.rayleigh[k] * std::exp(-h / air_.rayleigh_height) +
               (air_.mie_scattering[k] + air_.mie_absorption[k]) * std::exp(-h / air_.mie_height) +
               air_.absorption[k] * layer;
    }

    Atmosphere air_;
    double ground_;
};

class Sky : public RendererTest {
  protected:
    const Ellipsoid ball{6360000, 6360000, "earth"};
    static constexpr int kCells = 32;
    static constexpr double kEyeHeight = 500;

    // From a little above the ground at 0 N 0 E, where up is +x and north +z.
    DrawRequest look_up(double elevation_degrees, const Vec3& sun) const {
        const double e = elevation_degrees * kPi / 180;
        DrawRequest request;
        request.camera.eye = to_units({ball.a() + kEyeHeight, 0, 0}, length_unit(ball));
        request.camera.forward = {std::sin(e), 0, std::cos(e)};
        request.camera.up = {std::cos(e), 0, -std::sin(e)};
        request.camera.right = {0, 1, 0};
        request.camera.vertical_fov = 10 * kPi / 180;
        request.camera.width = request.camera.height = 17;
        request.light.direction = sun;
        request.light.ambient = 0;
        request.sky = true;
        return request;
    }
};

Vec3 sun_at(double elevation_degrees) {
    const double e = elevation_degrees * kPi / 180;
    return {std::sin(e), -std::cos(e), 0};  // west of 0 N 0 E
}

TEST_F(Sky, IsSingleScatteringWhereOnlyThatIsAskedFor) {
    Atmosphere air = *atmosphere_of("earth");
    air.multiple_scattering = false;
    Renderer& gpu = renderer(ball, kCells);
    gpu.set_atmosphere(air);
    const SingleScattering truth(air, ball.a());
    for (const double sun : {60.0, 20.0, 5.0}) {
        for (const double elevation : {90.0, 45.0, 15.0}) {
            SCOPED_TRACE("sun " + std::to_string(sun) + ", view " + std::to_string(elevation));
            const DrawRequest request = look_up(elevation, sun_at(sun));
            const Frame frame = gpu.draw(request, {});
            const Vec3 eye = eye_metres(ball, request.camera), way = request.camera.forward;
            const Rgb expected = truth.radiance(eye, way, truth.to_top(eye, way), request.light.direction);
            for (std::size_t k = 0; k < 3; ++k)  // 16 steps against 600: within 3 %
                EXPECT_NEAR(frame.colour.at(8, 8)[k], kPi * expected[k], 0.03 * kPi * expected[k]) << k;
            EXPECT_EQ(frame.colour.at(8, 8)[3], 0) << "the sky covers nothing";
        }
    }
}

// Light scattered more than once adds: half as much again in the blue at most, on Earth at noon.
TEST_F(Sky, HigherOrdersAddLight) {
    Renderer& gpu = renderer(ball, kCells);
    const DrawRequest request = look_up(45, sun_at(45));
    const Frame all = gpu.draw(request, {});
    Atmosphere air = *atmosphere_of("earth");
    air.multiple_scattering = false;
    gpu.set_atmosphere(air);
    const Frame single = gpu.draw(request, {});
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_GT(all.colour.at(8, 8)[k], 1.02 * single.colour.at(8, 8)[k]);
        EXPECT_LT(all.colour.at(8, 8)[k], 2 * single.colour.at(8, 8)[k]);
    }
}

TEST_F(Sky, IsBlueAtNoonAndTheSunIsRedAtItsSetting) {
    Renderer& gpu = renderer(ball, kCells);
    const Frame noon = gpu.draw(look_up(60, sun_at(70)), {});
    EXPECT_GT(noon.colour.at(8, 8)[2], 2 * noon.colour.at(8, 8)[0]);
    DrawRequest west = look_up(1, sun_at(1));
    west.camera.forward = west.light.direction;
    west.camera.right = {0, 0, 1};
    west.camera.up = {-west.camera.forward[1], west.camera.forward[0], 0};
    const Frame evening = gpu.draw(west, {});
    EXPECT_GT(evening.colour.at(8, 8)[0], 5 * evening.colour.at(8, 8)[2]) << "the sun's disc";
    EXPECT_GT(evening.colour.at(8, 8)[0], 20 * evening.colour.at(8, 2)[0]);
    const Frame night = gpu.draw(look_up(60, sun_at(-30)), {});
    EXPECT_LT(night.colour.at(8, 8)[2], 1e-4);
}

// A white plain at noon: the sun through the whole air, and the sky's own light, which a clear sky limits to
// a fifth.
TEST_F(Sky, LightsTheGroundThroughTheAir) {
    const Patches patches = make_meshes(ball, level_halves(4), kCells, [](const Vec3&) { return 0.0; });
    Renderer& gpu = renderer(ball, kCells);
    gpu.set_colours({"white", std::nullopt, {}, {{0, {{-1, {255, 255, 255}}, {1, {255, 255, 255}}}}}});
    DrawRequest request = look_up(-90, {1, 0, 0});
    request.camera.eye = to_units({ball.a() + 500, 0, 0}, length_unit(ball));
    const Frame frame = gpu.draw(request, patches);
    const Atmosphere air = *atmosphere_of("earth");
    const Rgb sun = SingleScattering(air, ball.a()).transmittance({ball.a(), 0, 0}, {1, 0, 0});
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_GT(frame.colour.at(8, 8)[k], sun[k]) << k;
        EXPECT_LT(frame.colour.at(8, 8)[k], sun[k] + 0.25) << k;
    }
    request.sky = false;
    EXPECT_NEAR(gpu.draw(request, patches).colour.at(8, 8)[0], 1, 1e-3);
}

// Mountains fade to the colour of the air, the more the further they are.
TEST_F(Sky, HazeGrowsWithDistance) {
    const Patches patches = make_meshes(ball, level_halves(5), kCells, [](const Vec3&) { return 0.0; });
    Renderer& gpu = renderer(ball, kCells);
    gpu.set_colours({"black", std::nullopt, {}, {{0, {{-1, {0, 0, 0}}, {1, {0, 0, 0}}}}}});
    double before = 0;
    for (const double height : {1e3, 5e3, 2e4, 8e4}) {
        DrawRequest request = look_up(-90, sun_at(60));
        request.camera.eye = to_units({ball.a() + height, 0, 0}, length_unit(ball));
        const float blue = gpu.draw(request, patches).colour.at(8, 8)[2];
        EXPECT_GT(blue, before);
        before = blue;
    }
    EXPECT_GT(before, 0.02);
}

TEST_F(Sky, BodiesWithoutAirHaveABlackOne) {
    const Ellipsoid moon = Ellipsoid::moon();
    Renderer& gpu = renderer(moon, kCells);
    const Patches patches = make_meshes(moon, level_halves(3), kCells, [](const Vec3&) { return 0.0; });
    DrawRequest request;
    request.camera = look_down(moon, {0, 0}, 3 * moon.a(), 64, 64, 60);
    const Frame without = gpu.draw(request, patches);
    request.sky = true;
    const Frame with = gpu.draw(request, patches);
    EXPECT_EQ(without.colour.values, with.colour.values);
    EXPECT_EQ(with.counters.table_ms, 0);
}

TEST_F(Sky, SwitchedOffItCostsNothingAndChangesNothing) {
    const Patches patches = make_meshes(ball, level_halves(3), kCells, [](const Vec3&) { return 0.0; });
    Renderer& gpu = renderer(ball, kCells);
    DrawRequest request;
    request.camera = look_down(ball, {10, 20}, 3 * ball.a(), 64, 64, 60);
    const Frame before = gpu.draw(request, patches);
    EXPECT_EQ(before.counters.table_ms, 0);
    request.sky = request.water = true;
    const Frame with = gpu.draw(request, patches);
    EXPECT_GT(with.counters.table_ms, 0);
    EXPECT_NE(before.colour.values, with.colour.values);
    request.sky = request.water = false;
    const Frame after = gpu.draw(request, patches);
    EXPECT_EQ(before.colour.values, after.colour.values);
    EXPECT_EQ(after.counters.table_ms, 0) << "tables are made once";
}

class Water : public RendererTest {
  protected:
    const Ellipsoid body = Ellipsoid::earth();
    static constexpr int kCells = 32, kSize = 128;
};

// From space, under a low wind, the sea is brightest where its level surface mirrors the sun: where the
// vertical halves the angle between the ways to the eye and to the sun.
TEST_F(Water, GlintsWhereItMirrorsTheSun) {
    const Patches patches = make_meshes(body, level_halves(4), kCells, [](const Vec3&) { return -3000.0; });
    Renderer& gpu = renderer(body, kCells);
    DrawRequest request;
    request.camera = look_down(body, {10, 20}, 4 * body.a(), kSize, kSize, 32);
    request.light.direction = direction(Geodetic{-15, 60});
    request.light.ambient = 0;
    request.water = true;
    request.wind = 1;
    const Frame frame = gpu.draw(request, patches);
    const Vec3 eye = eye_metres(body, request.camera);
    float brightest = 0;
    std::array<int, 2> at{};
    double nearest = 10;
    std::array<int, 2> mirror{};
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const Vec3 way = ray(request.camera, x + 0.5, y + 0.5);
            const auto t = hit(body, 0, eye, way);
            if (!t) continue;
            if (frame.colour.at(x, y)[0] > brightest) brightest = frame.colour.at(x, y)[0], at = {x, y};
            const Vec3 n = body.normal_height(sum(eye, scaled(*t, way))).normal;
            const Vec3 half = unit(sum(request.light.direction, scaled(-1, unit(way))));
            const double off = std::acos(std::min(dot(n, half), 1.0));
            if (off < nearest) nearest = off, mirror = {x, y};
        }
    ASSERT_LT(nearest, 0.02);
    EXPECT_LE(std::abs(at[0] - mirror[0]), 3);
    EXPECT_LE(std::abs(at[1] - mirror[1]), 3);
    const Frame dry = [&] {
        DrawRequest r = request;
        r.water = false;
        return gpu.draw(r, patches);
    }();
    EXPECT_GT(brightest, 3 * dry.colour.at(mirror[0], mirror[1])[0]);
}

TEST_F(Water, LeavesLandAlone) {
    const auto half = [](const Vec3& n) { return n[1] > 0.3 ? 1500.0 : -1500.0; };
    const Patches patches = make_meshes(body, level_halves(4), kCells, half);
    Renderer& gpu = renderer(body, kCells);
    DrawRequest request;
    request.camera = look_down(body, {0, 20}, 4 * body.a(), kSize, kSize, 32);
    request.light.direction = direction(Geodetic{0, 20});
    request.aovs.height = true;
    const Frame dry = gpu.draw(request, patches);
    request.water = true;
    const Frame wet = gpu.draw(request, patches);
    int land = 0, sea = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const float h = dry.height.at(x, y)[0];
            if (h == 1500) {
                ASSERT_EQ(dry.colour.at(x, y)[1], wet.colour.at(x, y)[1]) << x << ", " << y;
                ++land;
            }
            sea += h == -1500 && dry.colour.at(x, y)[1] != wet.colour.at(x, y)[1];
        }
    EXPECT_GT(land, 500);
    EXPECT_GT(sea, 500);
}

// From a ship, over a sea floor at 4 km: the horizon of the water lies near that of the ellipsoid, not two
// degrees deeper.
TEST_F(Water, ReachesItsOwnHorizon) {
    const Patches patches = make_meshes(body, level_halves(6), kCells, [](const Vec3&) { return -4000.0; });
    Renderer& gpu = renderer(body, kCells);
    DrawRequest request;
    Camera& c = request.camera;
    c.eye = to_units({body.a() + 30, 0, 0}, length_unit(body));
    c.forward = {0, 1, 0};
    c.right = {0, 0, -1};
    c.up = {1, 0, 0};
    c.vertical_fov = 8 * kPi / 180;
    c.width = 9;
    c.height = 400;
    request.light.direction = unit({1, 0.2, 0.1});
    request.water = true;
    request.background = {1, 0, 1};
    const Frame frame = gpu.draw(request, patches);
    int first = 0;
    while (first < c.height && frame.colour.at(4, first)[3] == 0) ++first;
    request.sky = true;
    const Frame hazy = gpu.draw(request, patches);
    for (const float v : hazy.colour.values) ASSERT_TRUE(std::isfinite(v));
    for (int y = first + 2; y < c.height; ++y) ASSERT_EQ(hazy.colour.at(4, y)[3], 1) << y;
    const double dip = std::acos(body.a() / (body.a() + 30)),
                 expected = 200 + c.focal_pixels() * std::tan(dip);
    EXPECT_NEAR(first, expected, 1.5);
    for (const float v : frame.colour.values) ASSERT_TRUE(std::isfinite(v));
    for (int y = first + 2; y < c.height; ++y) {
        ASSERT_EQ(frame.colour.at(4, y)[3], 1) << y;
        ASSERT_LT(frame.colour.at(4, y)[0], frame.colour.at(4, y)[2] + 0.05f) << y << ": no magenta";
    }
}

TEST_F(Water, NeedsATableWithASea) {
    Renderer& gpu = renderer(body, kCells);
    gpu.set_colours(mars_colours());
    DrawRequest request;
    request.camera = look_down(body, {0, 20}, 4 * body.a(), 16, 16, 32);
    request.water = true;
    EXPECT_THROW(gpu.draw(request, {}), Error);
}

}  // namespace

}  // namespace carat::test
