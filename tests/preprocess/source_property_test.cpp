// The height is a pure function of the place: of no thread, batch, cache or neighbour; and it has no seams.
#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "carat/globe/error.hpp"
#include "raster_maker.hpp"

namespace carat::test {
namespace {

// A planet of three layers: a world with holes, a projected inset, a fine inset that crosses 180.
std::vector<LayerOptions> layers(const Folder& folder, Resampling r) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> noise(0, 1000);
    const Value rough = [&](double, double) { return noise(random); };
    const Value holed = [&](double, double) {
        const double h = noise(random);
        return h < 200 ? -9999 : h;
    };
    RasterSpec world{1440, 720};
    world.transform = {-180, 0.25, 0, 90, 0, -0.25};
    world.type = GDT_Int16;
    world.options = {"TILED=YES", "COMPRESS=DEFLATE"};
    RasterSpec inset{500, 300};
    inset.transform = {179, 0.004, 0, 10, 0, -0.004};
    inset.type = GDT_Float32;
    inset.nodata = -9999;
    RasterSpec utm{300, 300};
    utm.transform = {400000, 300, 0, 5200000, 0, -300};
    utm.epsg = 32633;
    utm.nodata = -9999;
    return {layer_of(write_raster(folder.file("utm.tif"), utm, holed), r),
            layer_of(write_raster(folder.file("inset.tif"), inset, holed), r),
            layer_of(write_raster(folder.file("world.tif"), world, rough), r)};
}

std::vector<Vec3> places(int count) {
    std::mt19937_64 random(12);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<Vec3> out;
    while (static_cast<int>(out.size()) < count) {
        Vec3 n{normal(random), normal(random), normal(random)};
        const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (double& x : n) x /= length;
        out.push_back(n);
        out.push_back(at(8.8 + 1.2 * unit(random), 179 + 2 * unit(random)));
        out.push_back(at(46.2 + 0.8 * unit(random), 13.7 + 1.2 * unit(random)));
    }
    for (const double lat : {90.0, -90.0, 0.0, 89.9, -89.95})
        for (const double lon : {-180.0, 180.0, 0.0, 90.0, -90.0, 45.0}) out.push_back(at(lat, lon));
    return out;
}

TEST(SourceProperty, BatchesThreadsAndCachesGiveTheSameBits) {
    const Folder folder;
    const std::vector<Vec3> n = places(12000);
    for (const Resampling r : {Resampling::nearest, Resampling::bilinear, Resampling::cubic}) {
        const std::vector<LayerOptions> options = layers(folder, r);
        const SourceStack stack = stack_of(options);
        std::vector<double> heights(n.size());
        std::vector<std::int8_t> layer(n.size());
        stack.sample(n, heights, layer);
        std::array<int, 4> used{};
        for (const std::int8_t k : layer) ++used[static_cast<std::size_t>(k + 1)];
        EXPECT_EQ(used[0], 0);
        for (const int k : {1, 2, 3}) EXPECT_GT(used[static_cast<std::size_t>(k)], 500);

        for (std::size_t i = 0; i < n.size(); i += 7) {
            const auto value = stack.sample(n[i]);
            ASSERT_EQ(std::memcmp(&value.height, &heights[i], sizeof(double)), 0) << i;
            ASSERT_EQ(value.layer, layer[i]) << i;
        }

        const SourceStack starved(options, Ellipsoid::earth(), kBase, 0);  // one tile a shard
        std::vector<std::vector<double>> again(5, std::vector<double>(n.size()));
        std::vector<std::thread> threads;
        for (std::size_t t = 0; t < again.size(); ++t)
            threads.emplace_back([&, t] {
                const std::size_t step = 100 * (t + 1) + t;  // every thread cuts other batches
                for (std::size_t i = 0; i < n.size(); i += step) {
                    const std::size_t count = std::min(step, n.size() - i);
                    starved.sample(std::span(n).subspan(i, count), std::span(again[t]).subspan(i, count), {});
                }
            });
        for (std::thread& t : threads) t.join();
        for (const auto& other : again)
            ASSERT_EQ(std::memcmp(other.data(), heights.data(), n.size() * sizeof(double)), 0)
                << to_string(r);
    }
}

// A smooth world, 1 degree samples. The step across a line is compared with that between two places as near
// each other elsewhere.
std::string smooth_world(const Folder& folder, bool at_nodes) {
    RasterSpec s{at_nodes ? 361 : 360, at_nodes ? 181 : 180};
    s.transform = at_nodes ? std::array<double, 6>{-180.5, 1, 0, 90.5, 0, -1}
                           : std::array<double, 6>{-180, 1, 0, 90, 0, -1};
    return write_raster(folder.file("world.tif"), s, [&](double u, double v) {
        const auto [lon, lat] = to_crs(s, u, v);
        const double d = 0.017453292519943295;
        return 1000 * std::cos(lat * d) * std::sin(3 * lon * d) + 500 * std::sin(lat * d) +
               40 * std::sin(lon * d);
    });
}

TEST(SourceProperty, NoSeamAt180) {
    for (const bool at_nodes : {false, true})
        for (const Resampling r : {Resampling::bilinear, Resampling::cubic}) {
            const Folder folder;
            const SourceStack stack = stack_of(smooth_world(folder, at_nodes), r);
            constexpr double kStep = 1e-7;
            for (double lat = -89; lat < 90; lat += 1.7) {
                const double west = stack.sample(at(lat, 180 - kStep)).height;
                const double there = stack.sample(at(lat, 180)).height;
                EXPECT_EQ(there, stack.sample(at(lat, -180)).height);
                EXPECT_NEAR(west, there, 100 * kStep);
                EXPECT_NEAR(stack.sample(at(lat, -180 + kStep)).height, there, 100 * kStep);
            }
        }
}

TEST(SourceProperty, ContinuousAtThePoles) {
    for (const bool at_nodes : {false, true})
        for (const Resampling r : {Resampling::bilinear, Resampling::cubic}) {
            const Folder folder;
            const SourceStack stack = stack_of(smooth_world(folder, at_nodes), r);
            for (const double pole : {90.0, -90.0}) {
                const double there = stack.sample(at(pole, 0)).height;
                EXPECT_NEAR(there, pole > 0 ? 500 : -500, 0.1);  // the mean of the last row
                for (double lon = -180; lon < 180; lon += 13) {
                    EXPECT_EQ(stack.sample(at(pole, lon)).height, there);
                    // From the pole through every row in small steps: no jump.
                    double last = there;
                    for (double off = 1e-6; off < 3; off += 0.01) {
                        const double h = stack.sample(at(pole > 0 ? 90 - off : off - 90, lon)).height;
                        ASSERT_NEAR(h, last, 1.5) << pole << ' ' << lon << ' ' << off;
                        last = h;
                    }
                }
            }
        }
}

// Files that share a grid are one raster: the same heights as from one file, at and around the borders too.
TEST(SourceProperty, MosaicEqualsOneFile) {
    const Folder folder;
    RasterSpec whole{700, 650};
    whole.transform = {170, 0.03, 0, 20, 0, -0.03};  // crosses 180
    const Value f = [](double u, double v) { return std::sin(u * 1.3) * 100 + std::cos(v * 0.7) * 50; };
    const std::string one = write_raster(folder.file("one.tif"), whole, f);
    LayerOptions mosaic;
    mosaic.feather = 0;
    const auto add = [&](int x, int y, int w, int h) {
        RasterSpec s = whole;
        s.width = w;
        s.height = h;
        s.transform[0] += x * 0.03;
        s.transform[3] -= y * 0.03;
        mosaic.files.push_back(
            write_raster(folder.file("part" + std::to_string(mosaic.files.size()) + ".tif"), s,
                         [&](double u, double v) { return f(u + x, v + y); }));
    };
    add(300, 200, 400, 450);
    add(0, 0, 333, 250);  // overlaps
    add(333, 0, 367, 200);
    add(0, 250, 300, 400);
    const SourceStack a = stack_of(one), b = stack_of({mosaic});
    EXPECT_EQ(b.layers()[0].samples, 700u * 650u);
    EXPECT_EQ(b.layers()[0].valid_samples, 700u * 650u);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> x(169.5, 191.5), y(0, 20.5);
    for (int i = 0; i < 20000; ++i) {
        const Vec3 n = at(y(random), x(random));
        const auto va = a.sample(n), vb = b.sample(n);
        ASSERT_EQ(va.layer, vb.layer);
        ASSERT_NEAR(va.height, vb.height, 1e-7);
    }
}

}  // namespace
}  // namespace carat::test
