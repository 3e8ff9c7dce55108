// carat fly: frames, statistics, the two modes, refusals. Drawing is skipped where there is no Vulkan device.
#include <algorithm>

#include "program.hpp"
#include "rasters.hpp"

namespace carat::test {
namespace {

class Fly : public Program {
  protected:
    void SetUp() override {
        Program::SetUp();
        write_raster(path("hills.tif"), hills());
        ASSERT_EQ(carat("build -q --layer hills.tif --tolerance 5 -o a.carat").exit, 0);
        std::ofstream(path("down.json")) << R"([{"time": 0, "lat": 0, "lon": 0, "height": 1e7},
            {"time": 0.5, "lat": 1, "lon": 1, "height": 2e4, "pitch": -20}])";
    }

    static constexpr const char* kDown = "fly a.carat --path down.json --size 32x24 --samples 1 ";

    // Lines of a table, split at commas.
    std::vector<std::vector<std::string>> table(const std::string& file) const {
        std::vector<std::vector<std::string>> rows;
        std::istringstream lines(contents(path(file)));
        for (std::string line; std::getline(lines, line);) {
            rows.emplace_back();
            std::istringstream cells(line);
            for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
        }
        return rows;
    }
};

#define CARAT_NEEDS_VULKAN()                                                                \
    if (const Outcome r = carat("render -q a.carat --eye 0,0,1e7 --size 8x8 -o probe.png"); \
        r.exit != 0 && contains(r.err, "(unsupported)"))                                    \
    GTEST_SKIP() << r.err

TEST_F(Fly, ConvergedFramesAreTheSameBytesEveryRunAndThoseOfRender) {
    CARAT_NEEDS_VULKAN();
    ASSERT_EQ(carat(std::string(kDown) + "--fps 10 --converged -o one").exit, 0);
    ASSERT_EQ(carat(std::string(kDown) + "--fps 10 --threads 1 -o two").exit, 0);
    int frames = 0;
    for (const auto& entry : fs::directory_iterator(path("one"))) {
        ++frames;
        EXPECT_EQ(contents(entry.path()), contents(path("two") / entry.path().filename()));
    }
    EXPECT_EQ(frames, 6);
    ASSERT_EQ(carat("render a.carat --eye 1,1,2e4 --pitch -20 --size 32x24 --samples 1 -o last.png").exit, 0);
    EXPECT_EQ(contents(path("one/frame-00006.png")), contents(path("last.png")));
}

TEST_F(Fly, StatisticsHaveALineAFrame) {
    CARAT_NEEDS_VULKAN();
    const Outcome r = carat(std::string(kDown) + "--fps 10 --stats s.csv --json -o frames");
    ASSERT_EQ(r.exit, 0) << r.err;
    const auto rows = table("s.csv");
    ASSERT_EQ(rows.size(), 7u);
    std::uint64_t pages = 0, triangles = 0;
    for (std::size_t k = 1; k < rows.size(); ++k) {
        ASSERT_EQ(rows[k].size(), rows[0].size());
        const auto at = [&](const std::string& column) {
            for (std::size_t c = 0; c < rows[0].size(); ++c)
                if (rows[0][c] == column) return std::stod(rows[k][c]);
            throw std::runtime_error("no column " + column);
        };
        EXPECT_EQ(at("frame"), static_cast<double>(k));
        EXPECT_EQ(at("converged"), 1);
        EXPECT_LE(at("worst_error_px"), 1);
        EXPECT_EQ(at("triangles"), at("patches") * 64 * 64);
        EXPECT_GE(at("frame_ms"), at("refine_ms"));
        for (const char* name :
             {"culled_frustum", "culled_horizon", "culled_back", "bytes_read", "decoded", "predicted",
              "uploaded", "selection_ms", "decode_ms", "build_ms", "upload_ms", "stall_ms", "gpu_ms"})
            EXPECT_GE(at(name), 0) << name;
        pages += static_cast<std::uint64_t>(at("pages_read"));
        triangles += static_cast<std::uint64_t>(at("triangles"));
    }
    const auto json = r.json();
    EXPECT_EQ(json.at("frames"), 6);
    EXPECT_EQ(json.at("converged_frames"), 6);
    EXPECT_EQ(json.at("read").at("pages"), pages);
    EXPECT_EQ(json.at("triangles"), triangles);
    EXPECT_EQ(json.at("uploads").at("stalled_frames"), 0) << "a small planet's patches fit the ring";
    EXPECT_GT(json.at("triangles_per_second"), 0);
    EXPECT_LE(json.at("frame_ms").at("p50"), json.at("frame_ms").at("p95"));
    EXPECT_LE(json.at("frame_ms").at("p99"), json.at("frame_ms").at("max"));
    EXPECT_FALSE(json.contains("share_over_budget"));
}

TEST_F(Fly, WithABudgetAFrameTakesWhatIsReady) {
    CARAT_NEEDS_VULKAN();
    const Outcome r = carat(
        "fly a.carat --path jumps-and-turns --at 10,20 --fps 2 --size 32x24 --samples 1 "
        "--error 0.01 --budget 0.5 --stats b.csv --json -o frames");
    ASSERT_EQ(r.exit, 0) << r.err;
    const auto json = r.json();
    EXPECT_EQ(json.at("frames"), 31);
    EXPECT_EQ(json.at("budget_ms"), 0.5);
    const auto rows = table("b.csv");
    ASSERT_EQ(rows.size(), 32u);
    int over = 0;
    for (std::size_t k = 1; k < rows.size(); ++k)
        for (std::size_t c = 0; c < rows[0].size(); ++c)
            if (rows[0][c] == "refine_ms") over += std::stod(rows[k][c]) > 0.5 ? 1 : 0;
    EXPECT_NEAR(json.at("share_over_budget").get<double>(), over / 31.0, 0.5 / 31);
    EXPECT_LT(json.at("converged_frames"), 31) << "half a millisecond is not enough for so small an error";
    EXPECT_TRUE(fs::exists(path("frames/frame-00031.png")));
}

// An eye at rest that looks straight down: all patches come at once, or with --upload a few a frame, on the
// device too. The staging ring takes them without a stall.
TEST_F(Fly, AnUploadBudgetIsKeptAndNothingStalls) {
    CARAT_NEEDS_VULKAN();
    std::ofstream(path("still.json")) << R"([{"time": 0, "lat": 1, "lon": 1, "height": 1e7, "pitch": -90},
        {"time": 1, "lat": 1, "lon": 1, "height": 1e7, "pitch": -90}])";
    const auto most_of = [&](const std::string& upload) {
        const Outcome r = carat(
            "fly a.carat --path still.json --fps 10 --size 32x24 --samples 1 --spacing 0 --error 0.001 "
            "--budget 10000 --stats u.csv --overwrite --json -o frames --upload " +
            upload);
        EXPECT_EQ(r.exit, 0) << r.err;
        const auto rows = table("u.csv");
        const auto column = [&](const std::string& name) {
            return static_cast<std::size_t>(std::find(rows[0].begin(), rows[0].end(), name) -
                                            rows[0].begin());
        };
        std::uint64_t most = 0, all = 0;
        for (std::size_t k = 1; k < rows.size(); ++k) {
            const std::uint64_t bytes = std::stoull(rows[k][column("bytes_uploaded")]);
            most = std::max(most, bytes);
            all += bytes;
            EXPECT_EQ(std::stod(rows[k][column("stall_ms")]), 0) << upload << ", frame " << k;
        }
        const auto uploads = r.json().at("uploads");
        EXPECT_EQ(uploads.at("bytes"), all);
        EXPECT_EQ(uploads.at("bytes_a_frame_max"), most);
        EXPECT_EQ(uploads.at("stalled_frames"), 0);
        EXPECT_EQ(uploads.at("stall_ms"), 0);
        return most;
    };
    constexpr std::uint64_t kPatch = 2145 * 32 + 32;
    EXPECT_GT(most_of("100M"), 40 * kPatch);
    // Copies of neighbours with new border normals may exceed it by those of one seam.
    EXPECT_LT(most_of("1M"), (1u << 20) + 8 * kPatch);
}

TEST_F(Fly, PicturesCanBeExr) {
    CARAT_NEEDS_VULKAN();
    ASSERT_EQ(carat(std::string(kDown) + "--fps 2 --format exr -o frames").exit, 0);
    EXPECT_TRUE(fs::exists(path("frames/frame-00002.exr")));
    EXPECT_EQ(carat(std::string(kDown) + "--fps 2 --format exr -o frames").exit, 2) << "overwritten";
}

// Read back by ffmpeg: as many frames as the flight has, of its size and rate, and the same file every run.
TEST_F(Fly, AFilmHasTheFramesOfTheFlight) {
    CARAT_NEEDS_VULKAN();
    ASSERT_EQ(carat(std::string(kDown) + "--fps 10 -o one.mp4").exit, 0);
    ASSERT_EQ(carat(std::string(kDown) + "--fps 10 -o two.mp4").exit, 0);
    EXPECT_EQ(contents(path("one.mp4")), contents(path("two.mp4")));
    EXPECT_EQ(carat(std::string(kDown) + "--fps 10 -o one.mp4").exit, 2) << "overwritten";
    const std::string probe =
        "ffprobe -v error -count_frames -select_streams v -of csv=p=0 -show_entries "
        "stream=codec_name,width,height,r_frame_rate,nb_read_frames '" +
        path("one.mp4").string() + "' > '" + path("probe.csv").string() + "'";
    ASSERT_EQ(std::system(probe.c_str()), 0);
    EXPECT_EQ(contents(path("probe.csv")), "h264,32,24,10/1,6\n");
    EXPECT_FALSE(fs::exists(path("one.mp4.part")));
}

TEST_F(Fly, NothingIsReplacedUnasked) {
    std::ofstream(path("kept.csv")) << "mine";
    const Outcome refused = carat(std::string(kDown) + "--fps 2 --stats kept.csv -o frames");
    EXPECT_EQ(refused.exit, 2) << refused.err;
    EXPECT_TRUE(contains(refused.err, "kept.csv: exists already")) << refused.err;
    EXPECT_EQ(contents(path("kept.csv")), "mine");
    EXPECT_FALSE(fs::exists(path("frames")));
    CARAT_NEEDS_VULKAN();
    EXPECT_EQ(carat(std::string(kDown) + "--fps 2 --stats kept.csv --overwrite -o frames").exit, 0);
    EXPECT_TRUE(contains(contents(path("kept.csv")), "worst_error_px"));
}

TEST_F(Fly, PipelinesAreKeptWhereSaid) {
    CARAT_NEEDS_VULKAN();
    ASSERT_EQ(carat(std::string(kDown) + "--fps 2 --pipeline-cache kept -o frames").exit, 0);
    ASSERT_TRUE(fs::is_directory(path("kept")));
    EXPECT_FALSE(fs::is_empty(path("kept")));
}

TEST_F(Fly, WhatCannotBeFlownIsRefused) {
    const auto fails = [&](const std::string& options, int exit, const std::string& word) {
        const Outcome r = carat("fly a.carat -o frames " + options);
        EXPECT_EQ(r.exit, exit) << r.err;
        EXPECT_TRUE(contains(r.err, word)) << r.err;
    };
    fails("--path down.json --converged --budget 5", 2, "exclude each other");
    fails("--path nowhere", 1, "nowhere");
    fails("--path down.json --at 1,2", 2, "not round a place");
    std::ofstream(path("bad.json")) << "[{]";
    fails("--path bad.json", 1, "bad.json");
    EXPECT_FALSE(fs::exists(path("frames")));
}

}  // namespace
}  // namespace carat::test
