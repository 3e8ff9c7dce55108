// The benchmarks of the runtime, in short: what they say of a planet holds, and they notice what does not.
#include "program.hpp"
#include "rasters.hpp"

namespace carat::test {
namespace {

using Bench = Program;

#define CARAT_NEEDS_VULKAN(outcome) \
    if ((outcome).exit != 0 && contains((outcome).err, "(unsupported)")) GTEST_SKIP() << (outcome).err

TEST_F(Bench, WatertightFindsNoHoleInFourPlanets) {
    const Outcome r = carat("bench watertight --views 60 --json");
    CARAT_NEEDS_VULKAN(r);
    ASSERT_EQ(r.exit, 0) << r.out << r.err;
    std::uint64_t views = 0;
    const auto rows = r.json();
    ASSERT_EQ(rows.size(), 4u);
    for (const auto& row : rows) {
        EXPECT_EQ(row.at("holes"), 0) << row;
        EXPECT_GT(row.at("pixels"), 20'000) << row;
        views += row.at("views").get<std::uint64_t>();
    }
    EXPECT_EQ(views, 60u);
}

TEST_F(Bench, WatertightFindsAMissingPatch) {
    const Outcome r = carat("bench watertight --views 40 --control --json");
    CARAT_NEEDS_VULKAN(r);
    EXPECT_EQ(r.exit, 1) << r.err;
    for (const auto& row : r.json()) {
        EXPECT_GT(row.at("holes"), 0) << row;
        EXPECT_TRUE(contains(row.at("first_hole").get<std::string>(), "--eye")) << row;
    }
}

TEST_F(Bench, ErrorKeepsItsThresholds) {
    write_raster(path("hills.tif"), hills());
    const Outcome r = carat(
        "bench error --layer hills.tif --tolerances 2,50 --thresholds 0.25,8 --views 2 "
        "--points 100 --size 96x72 --at 1,2 --csv e.csv --svg e.svg --json");
    CARAT_NEEDS_VULKAN(r);
    ASSERT_EQ(r.exit, 0) << r.out << r.err;
    const auto rows = r.json();
    ASSERT_EQ(rows.size(), 4u);
    const auto at = [&](std::size_t k, const char* key) { return rows[k].at(key).get<double>(); };
    for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_LE(at(k, "excess_px"), 1e-3) << rows[k];
        EXPECT_GT(at(k, "points"), 50) << rows[k];
        EXPECT_LE(rows[k].at("error_px").at("rms"), rows[k].at("error_px").at("max"));
    }
    EXPECT_LT(rows[0].at("error_px").at("rms"), rows[1].at("error_px").at("rms"))
        << "a quarter pixel, and eight";
    EXPECT_LT(at(2, "file_bytes"), at(0, "file_bytes"));
    EXPECT_TRUE(contains(contents(path("e.csv")), "tolerance_m"));
    EXPECT_TRUE(contains(contents(path("e.svg")), "Error against triangles"));
}

}  // namespace
}  // namespace carat::test
