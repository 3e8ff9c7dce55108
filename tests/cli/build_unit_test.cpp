// carat build: layers, outputs, reports.
#include <set>

#include "program.hpp"
#include "rasters.hpp"

namespace carat::test {
namespace {

class Build : public Program {
  protected:
    void SetUp() override {
        Program::SetUp();
        write_raster(path("hills.tif"), hills());
        write_raster(path("low.tif"), flat(-50));
        // East of Greenwich 7 m, west of it 300 m.
        write_raster(path("halves.tif"), {64, 32, {-180, -90, 180, 90}, [](double, double lon) {
                                              return lon > 0 ? 7.0 : 300.0;
                                          }});
    }
    double height(const std::string& file, const std::string& place) const {
        return carat("query --json " + file + " " + place).json().at("points").at(0).at("height_m");
    }
    bool only_inputs() const {
        for (const auto& entry : fs::directory_iterator(path("")))
            if (entry.path().extension() != ".tif" && entry.path().extension() != ".txt") return false;
        return true;
    }
};

TEST_F(Build, ReportsAsTextOnStdout) {
    const Outcome r = carat("build --layer hills.tif --tolerance 2 -o a.carat");
    ASSERT_EQ(r.exit, 0) << r.err;
    EXPECT_TRUE(contains(r.out, "hills.tif"));
    EXPECT_TRUE(contains(r.out, "tolerance 2 m"));
    EXPECT_TRUE(contains(r.out, "expected ") && contains(r.out, "came out")) << r.out;
    EXPECT_TRUE(fs::exists(path("a.carat")));
}

TEST_F(Build, ReportsAsJson) {
    const Outcome r = carat("build --layer hills.tif --tolerance 2 --json -o a.carat");
    ASSERT_EQ(r.exit, 0) << r.err;
    const auto json = r.json();
    EXPECT_EQ(json.at("file_bytes"), fs::file_size(path("a.carat")));
    EXPECT_EQ(json.at("source_samples"), 1024 * 512);
    EXPECT_EQ(json.at("layers").size(), 1u);
    EXPECT_LE(json.at("max_error_m").get<double>(), 2.0);
    EXPECT_GT(json.at("max_error_m").get<double>(), 0.0);
    EXPECT_LE(json.at("rms_error_m").get<double>(), json.at("max_error_m").get<double>());
    EXPECT_EQ(json.at("coded_diamonds").get<int>() + json.at("zero_diamonds").get<int>(),
              json.at("refined_diamonds"));
}

TEST_F(Build, QuietPrintsNothing) {
    const Outcome r = carat("build -q --layer hills.tif --tolerance 2 -o a.carat");
    EXPECT_EQ(r.exit, 0);
    EXPECT_EQ(r.out + r.err, "");
}

TEST_F(Build, AListOfFilesMayBeLongerThanAName) {
    std::string list = "low.tif";
    for (int k = 0; k < 40; ++k) list += ",low.tif";
    const Outcome r = carat("build --dry-run --json --layer " + list + " --tolerance 2 -o a.carat");
    EXPECT_EQ(r.exit, 0) << r.err;
}

TEST_F(Build, DryRunWritesNothing) {
    const Outcome r = carat("build --dry-run --json --layer hills.tif --tolerance 2 -o a.carat");
    ASSERT_EQ(r.exit, 0) << r.err;
    const auto plan = r.json();
    EXPECT_TRUE(only_inputs());
    const auto report = carat("build --json --layer hills.tif --tolerance 2 -o a.carat").json();
    for (const char* key : {"refined_by_level", "refined_diamonds", "leaf_samples", "source_samples"})
        EXPECT_EQ(plan.at(key), report.at(key)) << key;
    const double bytes = plan.at("estimate").at("file_bytes");
    EXPECT_NEAR(bytes, report.at("file_bytes").get<double>(), 0.25 * bytes);
    EXPECT_GT(plan.at("estimate").at("seconds").get<double>(), 0);
    const double before_build = report.at("estimate").at("file_bytes");
    EXPECT_NEAR(before_build, report.at("file_bytes").get<double>(), 0.25 * before_build);
    EXPECT_LT(report.at("estimate").at("sampled_diamonds"), plan.at("estimate").at("sampled_diamonds"));
    EXPECT_TRUE(
        contains(carat("build --dry-run --layer hills.tif --tolerance 2 -o b.carat").out, "expected about"));
}

TEST_F(Build, AnExistingFileIsKeptUnlessOverwriteIsSaid) {
    std::ofstream(path("a.carat")) << "precious";
    const Outcome refused = carat("build --layer hills.tif --tolerance 2 -o a.carat");
    EXPECT_EQ(refused.exit, 2);
    EXPECT_TRUE(contains(refused.err, "a.carat: exists already")) << refused.err;
    EXPECT_EQ(contents(path("a.carat")), "precious");
    EXPECT_EQ(carat("build --overwrite --layer hills.tif --tolerance 2 -o a.carat").exit, 0);
    EXPECT_EQ(carat("verify a.carat").exit, 0);
}

TEST_F(Build, AFailureLeavesNothing) {
    std::ofstream(path("broken.tif")) << "no raster at all";
    const Outcome r = carat("build --layer hills.tif,broken.tif --tolerance 2 -o a.carat");
    EXPECT_EQ(r.exit, 1);
    EXPECT_TRUE(contains(r.err, "broken.tif")) << r.err;
    EXPECT_TRUE(only_inputs());
}

TEST_F(Build, TheFirstLayerThatHasDataWins) {
    ASSERT_EQ(carat("build --layer halves.tif --layer low.tif --tolerance 1 -o a.carat").exit, 0);
    EXPECT_NEAR(height("a.carat", "10 90"), 7, 1);
    ASSERT_EQ(carat("build --layer low.tif --layer halves.tif --tolerance 1 -o b.carat").exit, 0);
    EXPECT_NEAR(height("b.carat", "10 90"), -50, 1);
}

TEST_F(Build, AnOptionAppliesToTheLayerBeforeIt) {
    ASSERT_EQ(carat("build --layer halves.tif --nodata 7 --layer low.tif --tolerance 1 -o a.carat").exit, 0);
    EXPECT_NEAR(height("a.carat", "10 90"), -50, 1);
    EXPECT_NEAR(height("a.carat", "10 -90"), 300, 1);
    // The same option of the second layer: the first keeps its sevens.
    ASSERT_EQ(carat("build --layer halves.tif --layer low.tif --nodata 7 --tolerance 1 -o b.carat").exit, 0);
    EXPECT_NEAR(height("b.carat", "10 90"), 7, 1);
}

TEST_F(Build, EachLayerHasItsOwnOptions) {
    ASSERT_EQ(carat("build --tolerance=1 --layer=halves.tif --valid-range=200,400 -o a.carat --layer=low.tif "
                    "--valid-range=-10,10 --base-height -400")
                  .exit,
              0);
    EXPECT_NEAR(height("a.carat", "10 -90"), 300, 1);  // of the first
    EXPECT_NEAR(height("a.carat", "10 90"), -400, 1);  // a hole in both
}

TEST_F(Build, FilesOfALayerAreSeparatedByCommas) {
    const auto report = carat("build --json --layer halves.tif,low.tif --tolerance 1 -o a.carat").json();
    ASSERT_EQ(report.at("layers").size(), 1u);
    EXPECT_EQ(report.at("layers").at(0).at("files").size(), 2u);
}

TEST_F(Build, LayerOptionsMustFollowALayerOnce) {
    const Outcome early = carat("build --nodata 7 --layer low.tif --tolerance 1 -o a.carat");
    EXPECT_EQ(early.exit, 2);
    EXPECT_TRUE(contains(early.err, "--nodata stands ahead of the first --layer")) << early.err;
    const Outcome twice = carat("build --layer low.tif --nodata 7 --nodata 8 --tolerance 1 -o a.carat");
    EXPECT_EQ(twice.exit, 2);
    EXPECT_TRUE(contains(twice.err, "--nodata is given twice for layer low.tif")) << twice.err;
    const Outcome wrong = carat("build --layer low.tif --valid-range 5 --tolerance 1 -o a.carat");
    EXPECT_EQ(wrong.exit, 2);
    EXPECT_TRUE(contains(wrong.err, "--valid-range of layer low.tif")) << wrong.err;
}

TEST_F(Build, BodiesAndDatumsAreRecorded) {
    ASSERT_EQ(
        carat("build --layer low.tif --tolerance 1 --body 6400000,6350000 --vertical-datum egm96 -o a.carat")
            .exit,
        0);
    const auto info = carat("info --json a.carat").json();
    EXPECT_EQ(info.at("body").at("a_m"), 6400000);
    EXPECT_EQ(info.at("body").at("b_m"), 6350000);
    EXPECT_EQ(info.at("vertical_datum"), "egm96");
}

TEST_F(Build, BytesDoNotDependOnThreads) {
    ASSERT_EQ(carat("build --threads 1 --layer hills.tif --tolerance 1 -o a.carat").exit, 0);
    ASSERT_EQ(carat("build --threads 3 --memory 256M --layer hills.tif --tolerance 1 -o b.carat").exit, 0);
    EXPECT_EQ(contents(path("a.carat")), contents(path("b.carat")));
}

TEST_F(Build, LayersCanBeOrderedByResolution) {
    write_raster(path("coarse.tif"), {64, 32, {-180, -90, 180, 90}, [](double, double) { return 10.0; }});
    write_raster(path("fine.tif"), {32, 32, {0, 0, 16, 16}, [](double, double) { return 500.0; }});
    const std::string layers =
        "build -q --json --no-measure --overwrite --layer coarse.tif --layer fine.tif --tolerance 1 ";
    const auto given = carat(layers + "-o a.carat").json(),
               finest = carat(layers + "--layer-order finest -o b.carat").json();
    EXPECT_EQ(given.at("layers").at(0).at("name"), "coarse.tif");
    EXPECT_EQ(finest.at("layers").at(0).at("name"), "fine.tif");
    const auto height = [&](const std::string& file) {
        return carat("query --json " + file + " 8 8").json().at("points").at(0).at("height_m").get<double>();
    };
    EXPECT_NEAR(height("a.carat"), 10, 10);
    EXPECT_NEAR(height("b.carat"), 500, 10);
    EXPECT_EQ(carat(layers + "--layer-order random -o c.carat").exit, 2);
}

TEST_F(Build, ProgressCanBeReadByPrograms) {
    write_raster(path("hills.tif"), hills());
    const Outcome r = carat("build -q --json-progress --layer hills.tif --tolerance 5 -o a.carat");
    ASSERT_EQ(r.exit, 0) << r.err;
    std::istringstream lines(r.err);
    std::string line;
    std::set<std::string> stages;
    while (std::getline(lines, line)) {
        const auto p = nlohmann::json::parse(line);
        stages.insert(p.at("stage"));
        EXPECT_GE(p.at("seconds"), 0);
        if (p.contains("total")) {
            EXPECT_LE(p.at("done"), p.at("total"));
        }
    }
    EXPECT_TRUE(stages.contains("coding")) << r.err;
    EXPECT_TRUE(stages.contains("measuring")) << r.err;
}

TEST_F(Build, AGeoidIsNeverAppliedTwice) {
    write_raster(path("hills.tif"), hills());
    write_raster(path("geoid.tif"), flat(40));
    const std::string build = "build -q --layer hills.tif --geoid geoid.tif --tolerance 5 ";
    const Outcome other = carat(build + "--vertical-datum egm96 -o a.carat");
    EXPECT_EQ(other.exit, 2);
    EXPECT_TRUE(contains(other.err, "applied twice")) << other.err;
    const Outcome twice = carat(build + "--geoid geoid.tif -o a.carat");
    EXPECT_EQ(twice.exit, 2);
    EXPECT_FALSE(fs::exists(path("a.carat")));
}

}  // namespace
}  // namespace carat::test
