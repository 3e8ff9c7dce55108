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
        if (fs::exists(path("killed.carat"))) {
            ASSERT_TRUE(contents(path("killed.carat")) == expected) << "under its name, but not complete";
        }
        ++kills;
    }
    EXPECT_GE(kills, 2);
    EXPECT_TRUE(contents(path("killed.carat")) == expected) << kills << " kills";
    EXPECT_FALSE(fs::exists(path("killed.carat.build")));
}

// Killed after the output had got its name, before all temporary files were gone.
TEST_F(BuildResume, WhatWasCompleteIsNotBuiltAgain) {
    for (int tries = 0; !fs::exists(path("killed.carat.build")) || fs::exists(path("killed.carat"));
         ++tries) {
        ASSERT_LT(tries, 20);
        fs::remove(path("killed.carat"));
        const std::string killed = "cd '" + path("").string() + "' && timeout -s KILL " +
                                   std::to_string(0.5 + 0.3 * tries) + " '" CARAT_PROGRAM "' " +
                                   build("-q -o killed.carat") + " 2>/dev/null";
        ASSERT_NE(std::system(killed.c_str()), -1);
    }
    ASSERT_EQ(carat(build("--temp elsewhere -o killed.carat")).exit, 0);
    const std::string expected = contents(path("killed.carat"));
    ASSERT_TRUE(fs::exists(path("killed.carat.build")));

    EXPECT_NE(carat(build("-o killed.carat")).exit, 0) << "without --resume it is an output to be replaced";
    EXPECT_NE(carat(build("--resume --feather 0 -o killed.carat")).exit, 0) << "another build";
    EXPECT_NE(carat(build("--resume --coder gamma -o killed.carat")).exit, 0) << "another build";
    const auto report = carat(build("--resume --json -o killed.carat")).json();
    EXPECT_TRUE(report.at("already_complete").get<bool>());
    EXPECT_EQ(report.at("file_bytes").get<std::size_t>(), expected.size());
    EXPECT_TRUE(contents(path("killed.carat")) == expected);
    EXPECT_FALSE(fs::exists(path("killed.carat.build")));
    EXPECT_EQ(carat(build("--resume -o killed.carat")).exit, 0) << "and again";
}

// As Ctrl-C does: SIGINT, after ever longer times.
TEST_F(BuildResume, CtrlCStopsCleanlyAndSaysHowToGoOn) {
    ASSERT_EQ(carat(build("-o whole.carat")).exit, 0);
    const std::string expected = contents(path("whole.carat"));
    int told = 0;
    for (double seconds = 0.2; told < 2; seconds *= 1.2) {
        ASSERT_LT(seconds, 120);
        const std::string command = "cd '" + path("").string() + "' && timeout --preserve-status -s INT " +
                                    std::to_string(seconds) + " '" CARAT_PROGRAM "' " +
                                    build("--overwrite -o stopped.carat") + " >stdout.txt 2>stderr.txt";
        const int status = std::system(command.c_str());
        ASSERT_TRUE(WIFEXITED(status)) << "ended by the signal, not by itself";
        if (WEXITSTATUS(status) == 0) break;
        ASSERT_EQ(WEXITSTATUS(status), 130);
        EXPECT_FALSE(fs::exists(path("stopped.carat")));
        EXPECT_FALSE(fs::exists(path("stopped.carat.partial")));
        const std::string err = contents(path("stderr.txt"));
        if (err.empty()) continue;  // ended before it ran
        EXPECT_TRUE(contains(err, "interrupted")) << err;
        if (!fs::exists(path("stopped.carat.build"))) continue;  // nothing had been done yet
        EXPECT_TRUE(contains(err, "the same command with --resume goes on")) << err;
        EXPECT_TRUE(contains(err, "stopped.carat.build")) << err;
        ++told;
    }
    EXPECT_GE(told, 1);
    ASSERT_EQ(carat(build("--resume --overwrite -o stopped.carat")).exit, 0);
    EXPECT_TRUE(contents(path("stopped.carat")) == expected);
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
