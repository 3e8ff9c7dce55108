// Layer borders: weights by their rule, no steps, nothing changed where nothing lies below.
#include <gtest/gtest.h>

#include "carat/globe/error.hpp"
#include "raster_maker.hpp"

namespace carat::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Latitude, longitude -> pixel coordinates of a raster of 0.01 degree from 10 E, 50 N.
Vec3 pixel(double u, double v) { return at(50 - v * 0.01, 10 + u * 0.01); }

RasterSpec fine(int size) {
    RasterSpec s{size, size};
    s.transform = {10, 0.01, 0, 50, 0, -0.01};
    return s;
}
LayerOptions world(const Folder& folder, double height) {
    RasterSpec s{360, 180};
    s.transform = {-180, 1, 0, 90, 0, -1};
    return layer_of(write_raster(folder.file("world.tif"), s, [=](double, double) { return height; }));
}
double smoothstep(double x) {
    const double t = std::clamp(x, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

// Along the middle of a raster's side, D falls linearly: the weight is known in closed form.
TEST(Feather, WeightAtAStraightBorder) {
    const Folder folder;
    LayerOptions top =
        layer_of(write_raster(folder.file("t.tif"), fine(200), [](double, double) { return 1000; }));
    const LayerOptions below = world(folder, 0);
    for (const std::optional<double> feather : {std::optional<double>(), std::optional(10 * 895.0)}) {
        top.feather = feather;
        const SourceStack stack = stack_of({top, below});
        const double samples = feather ? *feather / stack.layers()[0].spacing : 16;
        for (double u = 0.01; u < 30; u += 0.37) {
            const auto value = stack.sample(pixel(u, 100));
            const double expected = smoothstep(u / samples);
            ASSERT_NEAR(value.height, 1000 * expected, 1e-6) << u;
            ASSERT_NEAR(value.weight, expected, 1e-9) << u;
            ASSERT_EQ(value.layer, 0);
        }
        EXPECT_EQ(stack.sample(pixel(-0.01, 100)).height, 0);
        EXPECT_EQ(stack.sample(pixel(-0.01, 100)).layer, 1);
    }
}

// Outer edges alone: the default of a larger raster, and a width of their own, wider than holes may have.
TEST(Feather, EdgesHaveTheirOwnWidth) {
    const Folder folder;
    LayerOptions top = layer_of(write_raster(folder.file("t.tif"), fine(800), [](double u, double v) {
        return static_cast<int>(u) == 400 && static_cast<int>(v) == 400 ? kNaN : 1000.0;
    }));
    const LayerOptions below = world(folder, 0);
    const double spacing = stack_of({top}).layers()[0].spacing;
    const auto expect = [&](double edges, double holes) {
        const SourceStack stack = stack_of({top, below});
        EXPECT_TRUE(stack.warnings().empty());
        for (double u = 0.5; u < 200; u += 3.7)
            ASSERT_NEAR(stack.sample(pixel(u, 200)).weight, smoothstep(u / edges), 1e-9) << u;
        for (int d = 0; d < 8; ++d)  // corners of pixels in the row of the hole
            ASSERT_NEAR(stack.sample(pixel(401 + d, 400)).weight, holes == 0 ? 1 : smoothstep(d / holes),
                        1e-6)
                << d;
    };
    top.feather = std::nullopt;
    expect(50, 4);
    top.feather_edges = 100 * spacing;
    expect(100, 4);
    top.feather = 0;
    expect(100, 0);
    top.feather = 6 * spacing;
    top.feather_edges = std::nullopt;
    expect(6, 6);
    top.feather_edges = 201 * spacing;
    EXPECT_EQ(stack_of({top, below}).warnings().size(), 1u) << "a quarter of the side is the most";
}

// Against a brute-force distance at samples, with random holes, over tile borders.
TEST(Feather, DistanceToTheNearestHole) {
    const Folder folder;
    constexpr int kSize = 600;
    RasterSpec s = fine(kSize);
    s.options = {"TILED=YES"};
    std::mt19937_64 random(5);
    std::vector<std::array<int, 2>> holes;
    for (int i = 0; i < 300; ++i)
        holes.push_back({static_cast<int>(random() % kSize), static_cast<int>(random() % kSize)});
    LayerOptions top = layer_of(write_raster(folder.file("t.tif"), s, [&](double u, double v) {
        for (const auto& [x, y] : holes)
            if (x == static_cast<int>(u) && y == static_cast<int>(v)) return kNaN;
        return 1000.0;
    }));
    const LayerOptions below = world(folder, 0);
    top.feather = 7.25 * stack_of({top}).layers()[0].spacing;
    const SourceStack stack = stack_of({top, below});
    const auto gap = [](int corner, int hole) { return std::max({hole - corner, corner - hole - 1, 0}); };
    for (int i = 0; i < 4000; ++i) {  // corners of pixels
        const int x = static_cast<int>(random() % (kSize + 1)), y = static_cast<int>(random() % (kSize + 1));
        double nearest = std::min({x, y, kSize - x, kSize - y});
        for (const auto& [hx, hy] : holes) nearest = std::min(nearest, std::hypot(gap(x, hx), gap(y, hy)));
        const auto value = stack.sample(pixel(x, y));
        ASSERT_NEAR(value.height, 1000 * smoothstep(nearest / 7.25), 1e-3) << x << ' ' << y;
    }
}

TEST(Feather, NoStepAnywhere) {
    const Folder folder;
    LayerOptions top = layer_of(write_raster(folder.file("t.tif"), fine(200), [](double u, double v) {
        return std::hypot(u - 90, v - 110) < 30 ? kNaN : 1000.0;
    }));
    top.feather = std::nullopt;
    RasterSpec other = fine(150);
    other.transform[0] += 1.203;
    other.transform[3] -= 0.507;
    LayerOptions middle =
        layer_of(write_raster(folder.file("m.tif"), other, [](double, double) { return 500.0; }));
    middle.feather = std::nullopt;
    const LayerOptions below = world(folder, 0);
    const SourceStack stack = stack_of({top, middle, below});
    constexpr double kStep = 0.05;  // samples; smoothstep over 4 samples rises at most 1.5/4 a sample
    int blended = 0;
    for (double v = -5; v < 215; v += 13.7) {
        double last = stack.sample(pixel(-6, v)).height;
        for (double u = -6; u < 290; u += kStep) {
            const auto value = stack.sample(pixel(u, v));
            ASSERT_NEAR(value.height, last, 3 * 1000 * 1.5 / 4 * kStep) << u << ' ' << v;
            blended += value.weight < 1 ? 1 : 0;
            last = value.height;
        }
    }
    EXPECT_GT(blended, 500);
}

TEST(Feather, NothingBelowNothingChanged) {
    const Folder folder;
    const Value rough = [](double u, double v) { return std::sin(u) * 100 + std::cos(v * 3) * 77; };
    LayerOptions plain = layer_of(write_raster(folder.file("t.tif"), fine(100), rough));
    LayerOptions feathered = plain;
    feathered.feather = std::nullopt;
    RasterSpec elsewhere = fine(50);
    elsewhere.transform[0] = -70;
    const LayerOptions other =
        layer_of(write_raster(folder.file("o.tif"), elsewhere, [](double, double) { return 1; }));
    const SourceStack a = stack_of({plain, other}), b = stack_of({feathered, other});
    for (double u = 0.1; u < 100; u += 1.3)
        for (const double v : {0.2, 3.0, 50.0, 99.9}) {
            ASSERT_EQ(a.sample(pixel(u, v)).height, b.sample(pixel(u, v)).height);
            ASSERT_EQ(b.sample(pixel(u, v)).weight, 1);
        }
    EXPECT_EQ(b.sample(pixel(-0.1, 50)).layer, kBaseLayer);
}

// A world raster has no border at 180 and at the poles.
TEST(Feather, NoBorderAcross180AndThePoles) {
    const Folder folder;
    LayerOptions top = world(folder, 1000);
    top.feather = std::nullopt;
    RasterSpec s{36, 18};
    s.transform = {-180, 10, 0, 90, 0, -10};
    const LayerOptions below =
        layer_of(write_raster(folder.file("b.tif"), s, [](double, double) { return 0; }));
    const SourceStack stack = stack_of({top, below});
    for (double x = -180; x <= 180; x += 0.7)
        for (const double lat : {90.0, 89.7, 40.0, -89.9, -90.0})
            ASSERT_EQ(stack.sample(at(lat, x)).height, 1000);
}

TEST(Feather, Options) {
    const Folder folder;
    LayerOptions top =
        layer_of(write_raster(folder.file("t.tif"), fine(10), [](double, double) { return 1; }));
    top.feather = -1;
    EXPECT_EQ(refusal({top}, "t.tif"), ErrorCode::usage);
    top.feather = 1e6;
    EXPECT_EQ(stack_of({top}).warnings().size(), 1u);
}

// Batches of any cut, threads or none: the same bits.
TEST(Feather, PureFunctionOfThePlace) {
    const Folder folder;
    std::mt19937_64 random(8);
    LayerOptions top = layer_of(write_raster(folder.file("t.tif"), fine(300), [&](double, double) {
        return random() % 300 == 0 ? kNaN : static_cast<double>(random() % 1000);
    }));
    top.feather = std::nullopt;
    const SourceStack stack = stack_of({top, world(folder, 123)});
    std::uniform_real_distribution<double> place(-5, 305);
    std::vector<Vec3> n;
    for (int i = 0; i < 5000; ++i) n.push_back(pixel(place(random), place(random)));
    std::vector<double> heights(n.size());
    stack.sample(n, heights, {});
    for (std::size_t i = 0; i < n.size(); ++i) ASSERT_EQ(stack.sample(n[i]).height, heights[i]);
}

}  // namespace
}  // namespace carat::test
