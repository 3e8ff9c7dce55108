// The bench tells the truth: what it measures was decoded, keeps the bound, and covers every sample.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "carat/bench/codec_bench.hpp"
#include "carat/bench/plane.hpp"
#include "carat/globe/error.hpp"

namespace carat::bench {
namespace {

// Hills, a step and a little noise.
Raster hills(int width, int height, bool integer) {
    Raster r;
    r.width = width;
    r.height = height;
    r.integer = integer;
    std::uint32_t noise = 1;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            noise = noise * 1664525u + 1013904223u;
            const double h = 900 * std::sin(x * 0.021) * std::cos(y * 0.017) + (x > width / 2 ? 120 : 0) +
                             static_cast<double>(noise >> 28) * 0.25;
            if (integer)
                r.whole.push_back(static_cast<std::int16_t>(std::floor(h)));
            else
                r.real.push_back(static_cast<float>(h));
        }
    return r;
}

struct Shape {
    int width, height;
};

TEST(Plane, EverySampleKeepsTheBoundWhateverTheShape) {
    for (const Shape s :
         {Shape{1, 1}, {2, 1}, {1, 300}, {65, 65}, {66, 65}, {129, 129}, {200, 90}, {40, 257}})
        for (const bool integer : {true, false})
            for (const Mode mode : {Mode::interpolating, Mode::filtered, Mode::paper})
                for (int way = 0; way < 4; ++way) {
                    const double tolerance = way % 2 == 0 ? 0.5 : 3.0;
                    const Raster r = hills(s.width, s.height, integer);
                    PlaneCodec codec(r, {mode, way < 2 ? Coding::gamma() : Coding{}}, tolerance);
                    const std::size_t bytes = codec.encode(r);
                    Raster out = r.like();
                    codec.decode(out);
                    EXPECT_LE(compare(r, out).max, integer ? std::floor(tolerance) : tolerance)
                        << s.width << " x " << s.height << " mode " << static_cast<int>(mode);
                    EXPECT_EQ(codec.encode(r), bytes);
                }
}

TEST(Plane, RefinesOneDiamondForEachPairOfTriangles) {
    // 129 x 129 samples: the face, four half diamonds on its sides, four leaves.
    const PlanePlan plan = PlanePlan::of(129, 129);
    EXPECT_EQ(plan.k, 1);
    EXPECT_EQ(plan.refined, 5u);
    EXPECT_EQ(plan.leaves, 4u);
    EXPECT_EQ(plan.steps.size(), 9u);
    EXPECT_EQ(PlanePlan::of(65, 65).refined, 0u);
}

TEST(Plane, ShapesItCannotCoverAreRefused) {
    EXPECT_THROW(PlanePlan::of(0, 5), Error);
    EXPECT_THROW(PlanePlan::of(1 << 21, 1), Error);
}

TEST(Contestants, AllKeepTheBoundOnTilesAndWhole) {
    for (const bool integer : {true, false}) {
        const Raster r = hills(150, 100, integer);
        CodecBenchOptions options;
        options.tolerances = {0.5, 2};
        options.tile = 64;
        options.repeats = 1;
        const CodecTable table = bench_codecs(r, options);
        EXPECT_GE(table.rows.size(), 2 * contestants().size());
        for (const CodecRow& row : table.rows) {
            EXPECT_EQ(row.failure, "") << row.codec;
            EXPECT_TRUE(row.within) << row.codec << " " << row.unit << ": " << row.errors.max << " at "
                                    << row.tolerance;
            EXPECT_GT(row.bytes, 0u) << row.codec;
            const bool lossless = integer && row.tolerance == 0.5;
            EXPECT_TRUE(!lossless || row.errors.max == 0) << row.codec << ": 0.5 means lossless";
        }
    }
}

// The ends of int16 side by side: what is decoded must not wrap round.
TEST(Contestants, TheEndsOfTheTypeAreKept) {
    Raster r = hills(70, 70, true);
    for (std::size_t k = 0; k < r.whole.size(); ++k)
        r.whole[k] = (k * 7 + k / 70) % 3 == 0 ? INT16_MAX : INT16_MIN;
    CodecBenchOptions options;
    options.tolerances = {0.5, 16};
    options.tile = 64;
    options.repeats = 1;
    for (const CodecRow& row : bench_codecs(r, options).rows)
        EXPECT_TRUE(!row.failure.empty() || row.within)
            << row.codec << " " << row.unit << ": " << row.errors.max << " at " << row.tolerance;
}

TEST(Contestants, HeightsThatDoNotFitAreRefused) {
    Raster r = hills(40, 40, false);
    r.real[77] = 1e30f;
    CodecBenchOptions options;
    options.codecs = {"carat", "pred2", "jxl"};
    options.tolerances = {1};
    options.repeats = 1;
    for (const CodecRow& row : bench_codecs(r, options).rows) EXPECT_NE(row.failure, "") << row.codec;
}

TEST(Contestants, AnUnknownNameIsRefused) {
    CodecBenchOptions options;
    options.codecs = {"nosuch"};
    EXPECT_THROW(bench_codecs(hills(10, 10, true), options), Error);
}

TEST(Tiles, CutAndJoinedAreTheSame) {
    for (const int size : {0, 1, 7, 64, 500}) {
        const Raster r = hills(130, 61, true);
        Raster back = r.like();
        join_tiles(cut_tiles(r, size), size, back);
        EXPECT_EQ(back.whole, r.whole) << size;
    }
}

class Rasters : public ::testing::Test {
  protected:
    std::string write(const std::string& text) const {
        const auto path = std::filesystem::path(::testing::TempDir()) /
                          (std::string("carat_bench_") +
                           ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".asc");
        std::ofstream(path) << text;
        return path.string();
    }
    static constexpr const char* kHeader =
        "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n";
};

TEST_F(Rasters, HolesTakeTheSampleOnTheirLeftElseRightElseTheNearestRowAbove) {
    std::size_t filled = 0;
    const Raster r =
        read_raster(write(std::string(kHeader) + "-9999 5 -9999\n-9999 -9999 -9999\n1 2 3\n"), {}, filled);
    ASSERT_TRUE(r.integer);
    EXPECT_EQ(r.whole, (std::vector<std::int16_t>{5, 5, 5, 5, 5, 5, 1, 2, 3}));
    EXPECT_EQ(filled, 5u);
}

TEST_F(Rasters, BadCropsAndRastersWithoutSamplesAreRefused) {
    std::size_t filled = 0;
    const std::string file = write(std::string(kHeader) + "1 2 3\n4 5 6\n-9999 -9999 -9999\n");
    EXPECT_THROW(read_raster(file, Crop{1, 0, 3, 1}, filled), Error);
    EXPECT_THROW(read_raster(file, Crop{0, 0, 0, 1}, filled), Error);
    EXPECT_THROW(read_raster(file, Crop{0, 2, 3, 1}, filled), Error);
    EXPECT_THROW(read_raster("no/such/file.tif", {}, filled), Error);
    EXPECT_EQ(read_raster(file, Crop{1, 1, 2, 1}, filled).whole, (std::vector<std::int16_t>{5, 6}));
}

}  // namespace
}  // namespace carat::bench
