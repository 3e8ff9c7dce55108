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

TEST_F(Bench, DeadlineTellsWhoIsLate) {
    write_raster(path("hills.tif"), hills());
    ASSERT_EQ(carat("build --layer hills.tif --tolerance 5 -o hills.carat").exit, 0);
    const Outcome r =
        carat("bench deadline hills.carat --at 1,2 --budget 2 --frames 50 --size 320x200 --csv d.csv --json");
    ASSERT_EQ(r.exit, 0) << r.out << r.err;
    const auto rows = r.json();
    ASSERT_EQ(rows.size(), 4u) << "a path each";
    for (const auto& row : rows) {
        EXPECT_EQ(row.at("frames"), 50);
        EXPECT_LE(row.at("late_by_us"), row.at("late_frames")) << row;
        EXPECT_LE(row.at("late_frames"), 50);
        EXPECT_LE(row.at("own_p999_ms"), row.at("overrun_p999_ms")) << "without what the machine took";
        EXPECT_GE(row.at("other_sleeps"), 0);
        EXPECT_LE(row.at("within_share").get<double>(), 1 + 1e-9);
    }
    EXPECT_TRUE(contains(contents(path("d.csv")), "late_by_us"));
}

TEST_F(Bench, BuildRunsBesideGdalTranslate) {
    write_raster(path("hills.tif"), hills());
    const Outcome r =
        carat("bench build hills.tif hills.tif,hills.tif --rounds 2 --temp . --csv b.csv --json");
    if (r.exit != 0 && contains(r.err, "gdal_translate: cannot be run")) GTEST_SKIP() << r.err;
    ASSERT_EQ(r.exit, 0) << r.out << r.err;
    const auto rows = r.json();
    ASSERT_EQ(rows.size(), 3u) << "no peer for two rasters";
    EXPECT_EQ(rows[0].at("program"), "gdal_translate");
    for (const auto& row : rows) {
        EXPECT_EQ(row.at("rounds"), 2);
        for (const char* key : {"seconds", "processor_seconds", "peak_memory_bytes", "output_bytes"})
            EXPECT_GT(row.at(key), 0) << key << row;
        EXPECT_LE(row.at("least_seconds"), row.at("seconds"));
    }
    const auto& build = rows[1];
    const double ratio = build.at("seconds").get<double>() / rows[0].at("seconds").get<double>();
    EXPECT_NEAR(build.at("ratio_seconds"), ratio, 1e-9);
    double stages = 0;
    for (const char* stage : {"opening", "planning", "sampling", "coding", "summarising", "writing"})
        stages += build.at(std::string("stage_") + stage).get<double>();
    EXPECT_GT(stages, 0);
    EXPECT_FALSE(rows[2].contains("ratio_seconds"));
    EXPECT_TRUE(contains(contents(path("b.csv")), "ratio_processor_seconds"));
    for (const auto& entry : fs::directory_iterator(path(".")))
        EXPECT_FALSE(contains(entry.path().string(), "carat-build")) << "nothing is left";
}

TEST_F(Bench, BuildSaysWhyAProgramFailed) {
    std::ofstream(path("no.tif")) << "no raster";
    const Outcome r = carat("bench build no.tif --rounds 1 --no-peer --temp .");
    EXPECT_EQ(r.exit, 1);
    EXPECT_TRUE(contains(r.err, "no.tif")) << r.err;
}

}  // namespace
}  // namespace carat::test
