// Colours and light: the drawn albedo against the table, Lambert's law, antialiased outlines, smooth
// gradients.
#include <cmath>

#include "carat/globe/error.hpp"
#include "carat/globe/globe.hpp"
#include "planet.hpp"

namespace carat::test {

namespace {

class ColourImage : public RendererTest {
  protected:
    const Ellipsoid body = Ellipsoid::earth();
    static constexpr int kCells = 32, kWidth = 320, kHeight = 240;
};

TEST_F(ColourImage, AmbientLightShowsTheTableItself) {
    const auto hills = [](const Vec3& n) { return 3500 * n[0] * n[1] - 2500 * n[2] * n[0] + 800; };
    const Patches patches = make_meshes(body, level_halves(4), kCells, hills);
    Renderer& gpu = renderer(body, kCells);
    for (const ColourTable* table : {&earth_colours(), &mars_colours(), &moon_colours(), &grey_colours()}) {
        SCOPED_TRACE(table->name);
        gpu.set_colours(*table);
        DrawRequest request;
        request.camera = look_down(body, {10, 40}, 4 * body.a(), kWidth, kHeight, 25);
        request.light.ambient = 1;
        request.aovs.height = request.aovs.position = true;
        const Frame frame = gpu.draw(request, patches);
        int checked = 0;
        for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
                const float* pixel = frame.colour.at(x, y);
                const float height = frame.height.at(x, y)[0];
                if (pixel[3] == 0 || std::abs(height) < 150) continue;  // the coast is mixed within a pixel
                const float* p = frame.position.at(x, y);
                const Vec3 place = sum(eye_metres(body, request.camera), {p[0], p[1], p[2]});
                const Vec3 n = body.normal_height(place).normal;
                if (dot(n, unit({p[0], p[1], p[2]})) > -0.3) continue;  // at the limb a pixel spans a coast
                const auto expected = colour_at(*table, geodetic(n).latitude, height);
                // Half precision, and linear interpolation of encoded colours over a texel.
                for (std::size_t c = 0; c < 3; ++c)
                    ASSERT_NEAR(pixel[c], expected[c], 0.004) << x << ", " << y;
                ++checked;
            }
        }
        EXPECT_GT(checked, 10000);
    }
}

// Vertices in shadow keep the ambient light alone; in the sun, or with shadows off, nothing changes to the
// last bit.
TEST_F(ColourImage, ShadowsTakeTheSunsShare) {
    const auto with_share = [&](std::uint32_t share) {
        Patches patches;
        for (const auto& mesh : make_meshes(body, level_halves(3), kCells, [](const Vec3&) { return 0.0; })) {
            auto copy = std::make_shared<PatchMesh>(*mesh);
            copy->colours.assign(copy->vertices.size(), share << 24);
            patches.push_back(std::move(copy));
        }
        return patches;
    };
    RendererOptions options;
    options.validation = true;
    options.cells = kCells;
    options.shadowed = true;
    Renderer gpu(body, length_unit(body), options);
    DrawRequest request;
    request.camera = look_down(body, {10, 40}, 4 * body.a(), kWidth, kHeight, 25);
    request.light.direction = direction(Geodetic{-20, 75});
    request.light.ambient = 0.25;
    const Patches dark = with_share(0), half = with_share(51), bright = with_share(255);
    const Frame off = gpu.draw(request, dark);
    Renderer& plain = renderer(body, kCells);
    EXPECT_EQ(off.colour.values, plain.draw(request, dark).colour.values);
    request.shadows = true;
    const Frame shaded = gpu.draw(request, dark), dim = gpu.draw(request, half),
                lit = gpu.draw(request, bright);
    request.shadows = false;
    request.light.ambient = 0;
    const Frame sun = gpu.draw(request, dark);
    request.light.ambient = 1;
    const Frame albedo = gpu.draw(request, dark);
    for (std::size_t k = 0; k < sun.colour.values.size(); ++k) {
        if (k % 4 == 3) continue;
        const float ambient = 0.25f * albedo.colour.values[k];
        ASSERT_NEAR(lit.colour.values[k], off.colour.values[k], 1e-3)
            << k;  // halves, and a 1 that is interpolated
        ASSERT_NEAR(shaded.colour.values[k], ambient, 1e-3) << k;
        ASSERT_NEAR(dim.colour.values[k], ambient + 0.2f * 0.75f * sun.colour.values[k], 1e-3) << k;
    }
    for (const std::string& message : gpu.messages()) ADD_FAILURE() << message;
    request.shadows = true;
    EXPECT_THROW(plain.draw(request, dark), Error);
}

TEST_F(ColourImage, LambertsLawInLinearLight) {
    const Patches patches = make_meshes(body, level_halves(4), kCells, [](const Vec3&) { return 0.0; });
    const ColourTable white{"white", std::nullopt, {}, {{0, {{-1, {255, 255, 255}}, {1, {255, 255, 255}}}}}};
    Renderer& gpu = renderer(body, kCells);
    gpu.set_colours(white);
    DrawRequest request;
    request.camera = look_down(body, {10, 40}, 4 * body.a(), kWidth, kHeight, 25);
    request.light.direction = direction(Geodetic{-20, 75});
    request.light.ambient = 0.25;
    request.light.exposure = 0.5;
    const Frame frame = gpu.draw(request, patches);
    int lit = 0, dark = 0;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const Vec3 direction = ray(request.camera, x + 0.5, y + 0.5);
            const auto t = hit(body, -200, eye_metres(body, request.camera), direction);
            if (!t) continue;
            const Vec3 n =
                body.normal_height(sum(eye_metres(body, request.camera), scaled(*t, direction))).normal;
            const double cosine = dot(n, request.light.direction);
            if (dot(n, unit(direction)) > -0.1) continue;
            if (cosine > 0.05) {
                ++lit;
                ASSERT_NEAR(frame.colour.at(x, y)[0], 0.5 * (0.25 + 0.75 * cosine), 1e-3);
            } else if (cosine < -0.03) {
                ++dark;
                ASSERT_NEAR(frame.colour.at(x, y)[0], 0.5 * 0.25, 1e-3);
            }
        }
    }
    EXPECT_GT(lit, 10000);
    EXPECT_GT(dark, 1000);
}

// A slope of a few metres across the picture: the colour follows it without a step.
TEST_F(ColourImage, GradientsHaveNoStepsAtWholeMetres) {
    const auto ramp = [](const Vec3& n) { return 500 + 6 * n[1]; };
    const Patches patches = make_meshes(body, level_halves(4), kCells, ramp);
    DrawRequest request;
    request.camera = look_down(body, {0, 0}, 4 * body.a(), 512, 8, 0.3);
    request.light.ambient = 1;
    request.aovs.height = true;
    Renderer& gpu = renderer(body, kCells);
    const ColourTable steep{"steep", std::nullopt, {}, {{0, {{490, {0, 0, 0}}, {510, {255, 255, 255}}}}}};
    gpu.set_colours(steep);
    const Frame frame = gpu.draw(request, patches);
    const float rise = frame.height.at(511, 4)[0] - frame.height.at(0, 4)[0];
    ASSERT_GT(rise, 1.0f);
    const float span = frame.colour.at(511, 4)[0] - frame.colour.at(0, 4)[0];
    for (int x = 1; x < 512; ++x) {
        const float step = frame.colour.at(x, 4)[0] - frame.colour.at(x - 1, 4)[0];
        ASSERT_GE(step, 0) << x;
        ASSERT_LT(step, 4 * span / 512 + 2e-4f) << x;  // half precision is 1.2e-4 below 0.5
    }
}

// Colours of the meshes instead of the table's: each of its own latitude here.
TEST_F(ColourImage, ColoursOfMeshesAreDraped) {
    const auto tint = [](double latitude) {
        const auto v = static_cast<std::uint32_t>(std::lround(128 + latitude));
        return v | (255 - v) << 8 | 40u << 16 | 0xff000000u;
    };
    Patches patches;
    for (const auto& mesh : make_meshes(body, level_halves(4), kCells, [](const Vec3&) { return 100.0; })) {
        auto coloured = std::make_shared<PatchMesh>(*mesh);
        for (const PatchVertex& v : mesh->vertices) {
            const Vec3 place = to_metres(
                {mesh->anchor[0] + v.offset[0], mesh->anchor[1] + v.offset[1], mesh->anchor[2] + v.offset[2]},
                length_unit(body));
            coloured->colours.push_back(tint(geodetic(body.normal_height(place).normal).latitude));
        }
        patches.push_back(coloured);
    }
    RendererOptions options;
    options.validation = true;
    options.cells = kCells;
    options.coloured = true;
    Renderer gpu(body, length_unit(body), options);
    DrawRequest request;
    request.camera = look_down(body, {10, 40}, 4 * body.a(), kWidth, kHeight, 25);
    request.light.ambient = 1;
    request.aovs.position = true;
    const Frame frame = gpu.draw(request, patches);
    int checked = 0;
    for (int y = 0; y < kHeight; y += 2)
        for (int x = 0; x < kWidth; x += 2) {
            if (frame.colour.at(x, y)[3] == 0) continue;
            const float* p = frame.position.at(x, y);
            const Vec3 n =
                body.normal_height(sum(eye_metres(body, request.camera), {p[0], p[1], p[2]})).normal;
            if (dot(n, unit({p[0], p[1], p[2]})) > -0.3) continue;
            const double red = (128 + geodetic(n).latitude) / 255;
            ASSERT_NEAR(frame.colour.at(x, y)[0], srgb_decode(static_cast<float>(red)), 0.006);
            ASSERT_NEAR(frame.colour.at(x, y)[1], srgb_decode(static_cast<float>(1 - red)), 0.006);
            ASSERT_NEAR(frame.colour.at(x, y)[2], srgb_decode(40 / 255.0f), 0.002);
            ++checked;
        }
    EXPECT_GT(checked, 3000);
    EXPECT_TRUE(gpu.messages().empty());
    EXPECT_THROW(
        gpu.draw(request, make_meshes(body, level_halves(0), kCells, [](const Vec3&) { return 0.0; })), Error)
        << "meshes without colours";
}

// Ground of one height has one colour, at the edges of its triangles too, however low it is looked at: there
// depth changes by a tenth from a pixel to the next.
TEST_F(ColourImage, SamplesLeaveTheEdgesOfTrianglesAsTheyAre) {
    constexpr double kGround = 4000;
    constexpr int kLevel = 24;  // triangles of 76 m
    const Ellipsoid ball(6.4e6, 6.4e6);
    const Geodetic place{7, 33};
    const DiamondId below = locate(lattice_position(direction(place)), kLevel).half.diamond;
    const Patches patches =
        make_meshes(ball, {{below, 0}, {below, 1}}, kCells, [](const Vec3&) { return kGround; });
    Renderer& gpu = renderer(ball, kCells);
    ColourTable table;
    table.name = "from black to white";
    table.land = {{0, {{0, {0, 0, 0}}, {8000, {255, 255, 255}}}}};
    gpu.set_colours(table);
    const float expected = colour_at(table, 0, kGround)[0];
    const Vec3 at = ball.position(direction(place), kGround);
    DrawRequest request;
    request.light.ambient = 1;
    for (const int samples : {1, 4}) {
        SCOPED_TRACE(samples);
        request.samples = samples;
        int covered = 0;
        float worst = 0;
        for (const double over : {1.5, 3.0, 10.0, 30.0})
            for (const double roll : {0.0, 20.0}) {
                request.camera =
                    look_down(ball, place, std::sqrt(dot(at, at)) + over, kWidth, kHeight, 50, 80, roll);
                const Frame frame = gpu.draw(request, patches);
                for (int y = 0; y < kHeight; ++y)
                    for (int x = 0; x < kWidth; ++x) {
                        const float* pixel = frame.colour.at(x, y);
                        if (pixel[3] != 1) continue;
                        ++covered;
                        worst = std::max(worst, std::abs(pixel[0] - expected));
                    }
            }
        EXPECT_GT(covered, 100'000);
        EXPECT_LT(worst, 0.001) << "the table is of half precision; six hundredths without in_one";
    }
}

TEST_F(ColourImage, SamplesSmoothTheOutlineAndLeaveTheRest) {
    const Patches patches = make_meshes(body, level_halves(4), kCells, [](const Vec3&) { return 0.0; });
    Renderer& gpu = renderer(body, kCells);
    DrawRequest request;
    request.camera = look_down(body, {0, 0}, 4 * body.a(), 240, 180, 40);
    request.samples = 4;
    const Frame frame = gpu.draw(request, patches);
    ASSERT_EQ(frame.counters.samples, 4);
    double area = 0;
    int partial = 0;
    for (int y = 0; y < 180; ++y) {
        for (int x = 0; x < 240; ++x) {
            const float cover = frame.colour.at(x, y)[3];
            area += cover;
            partial += cover > 0 && cover < 1;
        }
    }
    // The limb of a sphere at 4 radii: an angle of asin(1/4) off the axis. The poles are flattened by 1/298.
    const double f = request.camera.focal_pixels(), radius = f * std::tan(std::asin(0.25));
    const double disc = std::acos(-1) * radius * radius * (1 - 1 / 298.257);
    EXPECT_NEAR(area, disc, 0.002 * disc);
    EXPECT_GT(partial, 200);
    request.samples = 8;
    EXPECT_LE(gpu.draw(request, patches).counters.samples, 8);
}

}  // namespace

}  // namespace carat::test
