// Hostile inputs: a typed error that names the file, or a right answer.
#include <gtest/gtest.h>

#include <fstream>

#include "carat/globe/error.hpp"
#include "raster_maker.hpp"

namespace carat::test {
namespace {

double constant(double, double) { return 42; }

std::string bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
void write_bytes(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

TEST(SourceFuzz, MissingEmptyAndForeignFiles) {
    const Folder folder;
    EXPECT_EQ(refusal({layer_of(folder.file("none.tif"))}, "none.tif"), ErrorCode::io);
    write_bytes(folder.file("empty.tif"), "");
    EXPECT_EQ(refusal({layer_of(folder.file("empty.tif"))}, "empty.tif"), ErrorCode::io);
    write_bytes(folder.file("text.tif"), "heights, but in words");
    EXPECT_EQ(refusal({layer_of(folder.file("text.tif"))}, "text.tif"), ErrorCode::io);
    LayerOptions with_bounds = layer_of(folder.file("text.tif"));
    with_bounds.bounds = {{0, 0, 1, 1}};
    EXPECT_EQ(refusal({with_bounds}, "text.tif"), ErrorCode::io);
    EXPECT_EQ(refusal({layer_of(folder.file("."))}, "."), ErrorCode::io);
    EXPECT_EQ(refusal({LayerOptions{}}, "layer"), ErrorCode::usage);
}

TEST(SourceFuzz, NothingIsPrinted) {
    const Folder folder;
    write_bytes(folder.file("bad.tif"), std::string("II*\0\x08\0\0\0\xff\xff", 10));
    testing::internal::CaptureStderr();
    refusal({layer_of(folder.file("bad.tif"))}, "bad.tif");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// Truncated at every length: refused when opened or read, or (directory at the front) all answers right.
TEST(SourceFuzz, TruncatedGeoTiff) {
    const Folder folder;
    RasterSpec s{40, 40};
    s.type = GDT_Float32;
    s.options = {"COMPRESS=DEFLATE", "BLOCKYSIZE=8"};
    std::mt19937_64 random(9);
    const std::string whole = bytes_of(
        write_raster(folder.file("whole.tif"), s, [&](double, double) { return double(random() % 1000); }));
    const SourceStack right = stack_of(folder.file("whole.tif"));
    int refused = 0;
    for (std::size_t length = 0; length < whole.size(); length += 7) {
        const std::string name = "cut" + std::to_string(length) + ".tif";
        write_bytes(folder.file(name), whole.substr(0, length));
        try {
            const SourceStack stack = stack_of(folder.file(name));
            for (double v = 0.5; v < 40; ++v)
                ASSERT_EQ(stack.sample(at(-v, 20)).height, right.sample(at(-v, 20)).height) << length;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
            ++refused;
        }
        std::filesystem::remove(folder.file(name));
    }
    EXPECT_GT(refused, static_cast<int>(whole.size() / 7) * 9 / 10);
}

TEST(SourceFuzz, FlippedBytesNeverCrash) {
    const Folder folder;
    RasterSpec s{24, 24};
    s.options = {"COMPRESS=DEFLATE"};
    const std::string whole = bytes_of(write_raster(folder.file("whole.tif"), s, constant));
    std::mt19937_64 random(17);
    for (int i = 0; i < 400; ++i) {
        std::string damaged = whole;
        damaged[random() % damaged.size()] ^= static_cast<char>(1u << (random() % 8));
        write_bytes(folder.file("damaged.tif"), damaged);
        try {
            const SourceStack stack = stack_of(folder.file("damaged.tif"));
            for (double v = 0; v < 24; v += 1.7) EXPECT_TRUE(std::isfinite(stack.sample(at(-v, v)).height));
            stack.finest_spacing(root_diamond(0));
        } catch (const Error&) {
        }
    }
}

TEST(SourceFuzz, OnePixel) {
    const Folder folder;
    RasterSpec s{1, 1};
    const SourceStack stack = stack_of(write_raster(folder.file("one.tif"), s, constant));
    for (const double x : {0.0, 0.3, 0.5, 1.0}) EXPECT_EQ(stack.sample(at(-x, x)).height, 42);
    EXPECT_EQ(stack.sample(at(-1.01, 0.5)).layer, kBaseLayer);
    EXPECT_LT(stack.finest_spacing(root_diamond(0)), 2e5);
}
TEST(SourceFuzz, OnePixelPlanet) {
    const Folder folder;
    RasterSpec s{1, 1};
    s.transform = {-180, 360, 0, 90, 0, -180};
    for (const Resampling r : {Resampling::nearest, Resampling::bilinear, Resampling::cubic}) {
        const SourceStack stack = stack_of(write_raster(folder.file("one.tif"), s, constant), r);
        for (double lat = -90; lat <= 90; lat += 15)
            for (double lon = -180; lon <= 180; lon += 15) EXPECT_EQ(stack.sample(at(lat, lon)).height, 42);
    }
}

TEST(SourceFuzz, ComplexAndBandless) {
    const Folder folder;
    RasterSpec s{4, 4};
    s.type = GDT_CFloat32;
    EXPECT_EQ(refusal({layer_of(write_raster(folder.file("c.tif"), s, constant))}, "c.tif"),
              ErrorCode::unsupported);
    write_bytes(folder.file("zero.vrt"), "<VRTDataset rasterXSize=\"4\" rasterYSize=\"4\"></VRTDataset>");
    const auto code = refusal({layer_of(folder.file("zero.vrt"))}, "zero.vrt");
    EXPECT_TRUE(code == ErrorCode::unsupported || code == ErrorCode::io);
    LayerOptions options = layer_of(write_raster(folder.file("d.tif"), {4, 4}, constant));
    options.band = 2;
    EXPECT_EQ(refusal({options}, "d.tif"), ErrorCode::usage);
}

TEST(SourceFuzz, DegenerateGeotransforms) {
    const Folder folder;
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    int n = 0;
    for (const std::array<double, 6>& g : {std::array<double, 6>{0, 0, 0, 0, 0, -1},
                                           {0, 1, 0, 0, 0, 0},
                                           {0, 1, 2, 0, 2, 4},
                                           {nan, 1, 0, 0, 0, -1},
                                           {0, inf, 0, 0, 0, -1}}) {
        // A VRT says what it likes.
        const std::string inner = write_raster(folder.file("in.tif"), {4, 4}, constant);
        const std::string name = "g" + std::to_string(n++) + ".vrt";
        std::string text =
            "<VRTDataset rasterXSize=\"4\" rasterYSize=\"4\"><SRS>EPSG:4326</SRS><GeoTransform>";
        for (std::size_t k = 0; k < 6; ++k) text += (k > 0 ? "," : "") + std::to_string(g[k]);
        text +=
            "</GeoTransform><VRTRasterBand dataType=\"Float64\" band=\"1\"><SimpleSource><SourceFilename>" +
            inner + "</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>";
        write_bytes(folder.file(name), text);
        EXPECT_EQ(refusal({layer_of(folder.file(name))}, name), ErrorCode::usage);
    }
}

TEST(SourceFuzz, BrokenVrt) {
    const Folder folder;
    write_bytes(
        folder.file("b.vrt"),
        "<VRTDataset rasterXSize=\"4\" rasterYSize=\"4\"><SRS>EPSG:4326</SRS><GeoTransform>0,1,0,0,0,-1"
        "</GeoTransform><VRTRasterBand dataType=\"Float64\" band=\"1\"><SimpleSource><SourceFilename>"
        "nowhere.tif</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>");
    EXPECT_EQ(refusal({layer_of(folder.file("b.vrt"))}, "b.vrt"), ErrorCode::io);
}

TEST(SourceFuzz, NumbersThatMakeNoSense) {
    const Folder folder;
    LayerOptions options = layer_of(write_raster(folder.file("a.tif"), {4, 4}, constant));
    options.valid_range = {{5, 1}};
    EXPECT_EQ(refusal({options}, "a.tif"), ErrorCode::usage);
    EXPECT_THROW(SourceStack({}, Ellipsoid::earth(), std::nan(""), kCache), Error);
    EXPECT_THROW(stack_of(std::vector<LayerOptions>(200, layer_of(folder.file("a.tif")))), Error);
    const SourceStack stack = stack_of(folder.file("a.tif"));
    std::vector<Vec3> n(3, at(-1, 1));
    std::vector<double> h(2);
    EXPECT_THROW(stack.sample(n, h, {}), Error);
}

}  // namespace
}  // namespace carat::test
