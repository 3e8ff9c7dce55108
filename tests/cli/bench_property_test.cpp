// The benchmarks of the runtime, in short: what they say of a planet holds, and they notice what does not.
#include <set>

#include "program.hpp"
#include "rasters.hpp"

namespace carat::test {
namespace {

using Bench = Program;

#define CARAT_NEEDS_VULKAN(outcome) \
    if ((outcome).exit != 0 && contains((outcome).err, "(unsupported)")) GTEST_SKIP() << (outcome).err

// 240 views of four planets of different tolerance, in four picture sizes, from 1 to 16 pixels of error.
TEST_F(Bench, WatertightFindsNoHoleInFourPlanets) {
    const Outcome r = carat("bench watertight --views 240 --size 96x72,128x128,200x100,61x160 --json");
    CARAT_NEEDS_VULKAN(r);
    ASSERT_EQ(r.exit, 0) << r.out << r.err;
    std::set<double> tolerances;
    const auto rows = r.json();
    ASSERT_EQ(rows.size(), 4u);
    for (const auto& row : rows) {
        EXPECT_EQ(row.at("holes"), 0) << row;
        EXPECT_EQ(row.at("views"), 60) << row;
        EXPECT_EQ(row.at("sizes"), 4) << row;
        EXPECT_LT(row.at("error_px").at(0), 2) << row;
        EXPECT_GT(row.at("error_px").at(1), 12) << row;
        EXPECT_GT(row.at("pixels"), 500'000) << row;
        EXPECT_GT(row.at("judged").get<double>(), 0.9 * row.at("pixels").get<double>()) << row;
        tolerances.insert(row.at("tolerance_m").get<double>());
    }
    EXPECT_EQ(tolerances.size(), 4u);
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

TEST_F(Bench, ThresholdHoldsInEveryPixelAndIsNotHeldByCoarserPictures) {
    const auto waves = [](double lat, double lon) {
        return 2000 * std::cos(0.2 * lat) * std::sin(0.15 * lon);
    };
    const auto ridges = [](double lat, double lon) {
        return 800 + 500 * std::sin(200 * lat + std::cos(90 * lon)) * std::cos(150 * lon);
    };
    write_raster(path("waves.tif"), {720, 360, {-180, -90, 180, 90}, waves});
    write_raster(path("ridges.tif"), {600, 600, {28, 18, 32, 22}, ridges});
    ASSERT_EQ(carat("build --layer ridges.tif --layer waves.tif --tolerance 2 -o rough.carat").exit, 0);
    const std::string command =
        "bench threshold rough.carat --at 20,30 --views 14 --size 24x16 --error 0.1 --json ";
    const Outcome r = carat(command + "--csv t.csv");
    CARAT_NEEDS_VULKAN(r);
    ASSERT_EQ(r.exit, 0) << r.out << r.err;
    const auto rows = r.json();
    ASSERT_EQ(rows.size(), 8u) << "seven kinds, and together";
    for (const auto& row : rows)
        for (const char* direction : {"drawn_to_surface", "surface_to_drawn"}) {
            const auto& tally = row.at(direction);
            EXPECT_EQ(tally.at("beyond"), 0) << row;
            EXPECT_GT(tally.at("pixels"), 5) << row;
            std::uint64_t sum = 0;
            for (const std::uint64_t n : tally.at("tenths")) sum += n;
            EXPECT_EQ(sum, tally.at("pixels"));
        }
    EXPECT_GT(rows[7].at("drawn_to_surface").at("greatest"), 0.05);
    EXPECT_LT(rows[7].at("disagree"), 0.02 * 14 * 24 * 16);
    EXPECT_TRUE(contains(contents(path("t.csv")), "valley floor,2,surface_to_drawn"));

    const Outcome coarse = carat(command + "--draw-error 30");
    EXPECT_EQ(coarse.exit, 1) << coarse.out << coarse.err;
    for (const char* direction : {"drawn_to_surface", "surface_to_drawn"})
        EXPECT_GT(coarse.json()[7].at(direction).at("beyond"), 0) << direction;
}

TEST_F(Bench, ShimmerIsLessByMoreSamples) {
    const auto ridges = [](double lat, double lon) {
        return 800 + 500 * std::sin(200 * lat + std::cos(90 * lon)) * std::cos(150 * lon);
    };
    write_raster(path("ridges.tif"), {600, 600, {28, 18, 32, 22}, ridges});
    ASSERT_EQ(carat("build --layer ridges.tif --tolerance 2 -o ridges.carat").exit, 0);
    const Outcome r = carat(
        "bench shimmer ridges.carat --from 20,30,6000 --to 20.002,30.004,5990 --size 48x32 --frames 3 "
        "--json");
    CARAT_NEEDS_VULKAN(r);
    ASSERT_EQ(r.exit, 0) << r.err;
    const auto file = r.json().at(0);
    EXPECT_GT(file.at("reference_motion_rms"), 0.1) << "the way leads over ground in sight";
    const auto& remedies = file.at("remedies");
    ASSERT_EQ(remedies.size(), 5u);
    const auto at = [&](std::size_t k, const char* key) { return remedies[k].at(key).get<double>(); };
    EXPECT_EQ(remedies[2].at("remedy"), "4 samples");
    for (const char* key : {"flicker_rms", "error_rms"}) {
        EXPECT_GT(at(0, key), 0) << key;
        EXPECT_LT(at(2, key), at(0, key)) << key;
        EXPECT_LT(at(4, key), at(2, key)) << key;
    }
}

TEST_F(Bench, FramesAreCountedByFlightAndSize) {
    write_raster(path("hills.tif"), hills());
    ASSERT_EQ(carat("build --layer hills.tif --tolerance 5 -o hills.carat").exit, 0);
    const Outcome r =
        carat("bench frames hills.carat --at 1,2 --sizes 32x24,64x48 --frames 3 --csv f.csv --json");
    CARAT_NEEDS_VULKAN(r);
    ASSERT_EQ(r.exit, 0) << r.out << r.err;
    const auto json = r.json();
    EXPECT_FALSE(json.at("device").get<std::string>().empty());
    const auto& rows = json.at("rows");
    ASSERT_EQ(rows.size(), 8u) << "four paths, two sizes";
    for (std::size_t k = 0; k < 8; ++k) {
        const auto& row = rows[k];
        EXPECT_EQ(row.at("width"), k < 4 ? 32 : 64);
        EXPECT_EQ(row.at("frames"), 3);
        EXPECT_EQ(row.at("triangles").get<std::uint64_t>() % 4096, 0u);
        EXPECT_GT(row.at("triangles"), 0);
        const double fps = row.at("device_frames_per_second");
        if (fps > 0) {
            EXPECT_NEAR(row.at("device_triangles_per_second").get<double>() / fps,
                        row.at("triangles").get<double>() / 3, 1);
        }
        EXPECT_GT(row.at("frames_per_second"), 0);
        EXPECT_LE(row.at("triangles").get<std::uint64_t>(),
                  3 * row.at("most_triangles").get<std::uint64_t>());
    }
    EXPECT_EQ(carat("bench frames hills.carat --sizes 32x24,").exit, 2);
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
        EXPECT_GT(row.at("pages"), 0) << "a row that follows another one finds pages in memory";
        EXPECT_GT(row.at("jump_seconds"), 0);
        if (row.at("within_share") < 0.99) {
            EXPECT_GT(row.at("longest_over_seconds"), 0);
        }
    }
    EXPECT_TRUE(contains(contents(path("d.csv")), "late_by_us"));
}

TEST_F(Bench, RefineCountsWhatTheThreadsDid) {
    write_raster(path("hills.tif"), hills());
    ASSERT_EQ(carat("build --layer hills.tif --tolerance 5 -o hills.carat").exit, 0);
    const Outcome r =
        carat("bench refine hills.carat --threads 1,2 --diamonds 20 --rounds 3 --csv r.csv --json");
    ASSERT_EQ(r.exit, 0) << r.err;
    const auto json = r.json();
    ASSERT_EQ(json.at("rows").size(), 2u);
    EXPECT_GT(json.at("diamonds"), 0);
    EXPECT_LE(json.at("diamonds"), 20);
    // Four children of 65 * 66 / 2 vertices and heights.
    EXPECT_NEAR(json.at("bytes_a_diamond").get<double>(), 4 * 2145 * (32 + 4), 0.01 * 4 * 2145 * 36);
    for (const auto& row : json.at("rows")) {
        const auto at = [&](const char* key) { return row.at(key).get<double>(); };
        EXPECT_NEAR(at("samples_per_second") / at("diamonds_per_second"), 4096, 1);
        EXPECT_NEAR(at("vertices_per_second") / at("diamonds_per_second"), 4 * 2145, 1);
        EXPECT_GT(at("samples_per_core_second"), 0);
        EXPECT_NEAR(at("decode_share") + at("build_share"), 1, 1e-6);
        EXPECT_GT(at("build_share"), 0.05);
        EXPECT_GT(at("decode_share"), 0.05);
    }
}

// The second file has the first one's ground and nine times the rest, out of sight.
TEST_F(Bench, ScalingCostsNothingForWhatIsOutOfSight) {
    const auto region = [&](const std::string& name, double west) {
        const auto height = [west](double lat, double lon) {
            return 500 + 200 * std::cos(40 * lat) * std::sin(50 * (lon - west)) +
                   30 * std::cos(400 * lat + 300 * lon);
        };
        write_raster(path(name), {300, 300, {west, 0, west + 3, 3}, height});
        return " --layer " + name;
    };
    const std::string here = region("here.tif", 0);
    std::string layers = here;
    for (int k = 0; k < 8; ++k) layers += region("far" + std::to_string(k) + ".tif", 140 + 4 * k);
    ASSERT_EQ(carat("build" + here + " --tolerance 1 -o one.carat").exit, 0);
    ASSERT_EQ(carat("build" + layers + " --tolerance 1 -o nine.carat").exit, 0);
    const Outcome r =
        carat("bench scaling one.carat nine.carat --at 1,1 --frames 30 --size 320x200 --csv s.csv --json");
    ASSERT_EQ(r.exit, 0) << r.err;
    const auto rows = r.json();
    ASSERT_EQ(rows.size(), 2u);
    const auto ratio = [&](const char* key) {
        return rows[1].at(key).get<double>() / rows[0].at(key).get<double>();
    };
    EXPECT_GT(ratio("bytes"), 4);
    EXPECT_GT(ratio("diamonds"), 4);
    for (const char* key : {"triangles", "decoded"}) EXPECT_NEAR(ratio(key), 1, 0.2) << key;
    EXPECT_GT(rows[0].at("decoded"), 0);
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
