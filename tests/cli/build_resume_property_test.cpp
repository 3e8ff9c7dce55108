// The program killed while it builds, at any moment, and its memory.
#include <gtest/gtest.h>

#include <random>

#include "program.hpp"

namespace carat::test {
namespace {

class BuildResume : public Program {
  protected:
    void SetUp() override {
        Program::SetUp();
        ASSERT_EQ(carat("synth earth --size 1024 -o planet").exit, 0);
        for (const auto& entry : fs::directory_iterator(path("planet")))
            if (entry.path().extension() == ".tif")
                layers_ += " --layer planet/" + entry.path().filename().string();
        ASSERT_FALSE(layers_.empty());
    }
    std::string build(const std::string& rest) const { return "build --tolerance 5" + layers_ + " " + rest; }

    std::string layers_;
};

// `timeout` kills the program after ever longer times, until it completes.
TEST_F(BuildResume, KilledAtAnyMomentItGoesOnToTheSameBytes) {
    ASSERT_EQ(carat(build("-o whole.carat")).exit, 0);
    const std::string expected = contents(path("whole.carat"));
    std::mt19937 random(1);
    int kills = 0;
    double longest = 0.3;
    for (;; longest *= 1.15) {
        ASSERT_LT(kills, 60);
        const double seconds = longest * std::uniform_real_distribution(0.5, 1.0)(random);
        const std::string killed = "cd '" + path("").string() + "' && timeout -s KILL " +
                                   std::to_string(seconds) + " '" CARAT_PROGRAM "' " +
                                   build("--resume -q -o killed.carat") + " 2>/dev/null";
        const int status = std::system(killed.c_str());
        if (WIFEXITED(status) && WEXITSTATUS(status) == 0) break;
        EXPECT_FALSE(fs::exists(path("killed.carat"))) << "not under its name before it is complete";
        ++kills;
    }
    EXPECT_GE(kills, 2);
    EXPECT_TRUE(contents(path("killed.carat")) == expected) << kills << " kills";
    EXPECT_FALSE(fs::exists(path("killed.carat.build")));
}

TEST_F(BuildResume, PeakMemoryStaysBelowTheLimit) {
    const auto report = carat(build("--memory 256M --json -o a.carat")).json();
    EXPECT_LE(report.at("peak_memory_bytes").get<double>(), 256.0 * 1024 * 1024);
    EXPECT_GT(report.at("temporary_peak_bytes").get<double>(), 0);
    EXPECT_LE(report.at("temporary_peak_bytes").get<double>(), report.at("temporary_bytes").get<double>());
}

TEST_F(BuildResume, TemporaryFilesAreAnnounced) {
    const Outcome outcome = carat(build("--temp scratch -o a.carat"));
    ASSERT_EQ(outcome.exit, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "of temporary files in scratch/a.carat-")) << outcome.err;
    EXPECT_TRUE(fs::is_empty(path("scratch")));
}

}  // namespace
}  // namespace carat::test
