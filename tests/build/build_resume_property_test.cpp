// Reproducible and resumable: the bytes of a build depend on inputs and options alone, not on threads,
// memory, locale, or on how often it was stopped; what an interrupted build leaves is used only for the same
// build, and only if sound.
#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>
#include <cstdlib>
#include <locale>

#include "carat/globe/error.hpp"
#include "scratch.hpp"

namespace carat::test {
namespace {

constexpr std::size_t kMegabyte = std::size_t{1} << 20;

// Small patches, so that levels have several steps: 17 x 17 heights a diamond.
BuildOptions many_diamonds(const std::filesystem::path& folder, Mode mode = Mode::interpolating) {
    BuildOptions options = synthetic_build(synth::Kind::earth, folder, 512);
    options.log2_cells = 4;
    options.depth_bias = 2;
    options.mode = mode;
    options.overwrite = true;
    options.memory_bytes = 256 * kMegabyte;
    return options;
}

std::filesystem::path workspace(const BuildOptions& options) { return options.output.string() + ".build"; }

// Stops a build once a stage has done so many diamonds. Returns whether it was stopped.
bool stopped_at(const BuildOptions& options, BuildStage stage, std::uint64_t done) {
    try {
        build_repository(options, [&](const BuildProgress& p) { return p.stage != stage || p.done < done; });
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::usage) << e.what();
        if (done > 0) {
            EXPECT_NE(std::string(e.what()).find("--resume"), std::string::npos) << e.what();
        }
        EXPECT_FALSE(std::filesystem::exists(options.output.string() + ".partial"));
        return true;
    }
    return false;
}

class ResumeModes : public testing::TestWithParam<Mode> {};

TEST_P(ResumeModes, TheSameBytesOverThreadsMemoryAndResuming) {
    const Scratch scratch;
    BuildOptions options = many_diamonds(scratch.folder, GetParam());
    options.threads = 1;
    const std::uint64_t refined = build_repository(options).plan.refined;
    ASSERT_GT(refined, 2000u) << "several steps";
    const std::string expected = bytes_of(options.output);
    ASSERT_FALSE(expected.empty());
    std::size_t taken_over = 0;
    for (const int threads : {1, 2, 5})
        for (const std::size_t memory : {256 * kMegabyte, 2048 * kMegabyte})
            for (const bool resumed : {false, true}) {
                options.threads = threads;
                options.memory_bytes = memory;
                options.resume = false;
                std::filesystem::remove(options.output);
                if (resumed) {
                    ASSERT_TRUE(stopped_at(options, threads == 2 ? BuildStage::sampling : BuildStage::coding,
                                           refined * static_cast<unsigned>(threads) / 7));
                    ASSERT_FALSE(std::filesystem::exists(options.output));
                    options.resume = true;
                    options.threads = 6 - threads;
                    options.memory_bytes = 2304 * kMegabyte - memory;
                }
                taken_over += build_repository(options).resumed_files;
                EXPECT_TRUE(bytes_of(options.output) == expected)
                    << threads << " threads, " << memory << " bytes, resumed " << resumed;
                EXPECT_FALSE(std::filesystem::exists(workspace(options)));
            }
    EXPECT_GT(taken_over, 60u) << "resuming uses what is there";
}

INSTANTIATE_TEST_SUITE_P(All, ResumeModes, testing::Values(Mode::interpolating, Mode::filtered, Mode::paper));

TEST(Resume, StoppedAgainAndAgainInEveryStage) {
    const Scratch scratch;
    BuildOptions options = many_diamonds(scratch.folder);
    const std::uint64_t refined = build_repository(options).plan.refined;
    const std::string expected = bytes_of(options.output);
    options.resume = true;
    int stops = 0;
    for (const BuildStage stage :
         {BuildStage::sampling, BuildStage::coding, BuildStage::summarising, BuildStage::writing})
        for (const std::uint64_t share : {0, 2, 3})
            stops += stopped_at(options, stage, refined * share / 4) ? 1 : 0;
    EXPECT_GE(stops, 6) << "progress is reported ten times a second at most";
    build_repository(options);
    EXPECT_TRUE(bytes_of(options.output) == expected);
}

TEST(Resume, DamagedTemporaryFilesAreNotUsed) {
    const Scratch scratch;
    BuildOptions options = many_diamonds(scratch.folder);
    const std::uint64_t refined = build_repository(options).plan.refined;
    const std::string expected = bytes_of(options.output);
    for (const bool cut : {false, true}) {
        ASSERT_TRUE(stopped_at(options, BuildStage::coding, refined / 2));
        std::size_t damaged = 0;
        for (const auto& entry : std::filesystem::directory_iterator(workspace(options))) {
            const std::uintmax_t size = std::filesystem::file_size(entry.path());
            if (size < 1000 || ++damaged % 3 != 0) continue;
            if (cut) {
                std::filesystem::resize_file(entry.path(), size / 2);
                continue;
            }
            std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
            file.seekg(static_cast<std::streamoff>(size / 2));
            const char byte = static_cast<char>(file.get() ^ 0x10);
            file.seekp(static_cast<std::streamoff>(size / 2));
            file.put(byte);
        }
        ASSERT_GE(damaged, 3u);
        options.resume = true;
        build_repository(options);
        EXPECT_TRUE(bytes_of(options.output) == expected);
        options.resume = false;
    }
}

TEST(Resume, WithoutItLeftoversAreThrownAway) {
    const Scratch scratch;
    BuildOptions options = many_diamonds(scratch.folder);
    build_repository(options);
    const std::string expected = bytes_of(options.output);
    ASSERT_TRUE(stopped_at(options, BuildStage::coding, 1000));
    const BuildReport report = build_repository(options);
    EXPECT_EQ(report.resumed_files, 0u);
    EXPECT_TRUE(bytes_of(options.output) == expected);
    EXPECT_FALSE(std::filesystem::exists(workspace(options)));
}

// Tries to resume; returns the message of the refusal.
std::string refusal(BuildOptions options) {
    options.resume = true;
    try {
        build_repository(options);
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::usage);
        return e.what();
    }
    return "built";
}

TEST(Resume, ChangedOptionsAndInputsAreRefusedByName) {
    const Scratch scratch;
    BuildOptions options = many_diamonds(scratch.folder);
    ASSERT_TRUE(stopped_at(options, BuildStage::coding, 1000));
    BuildOptions other = options;
    other.tolerance = 6;
    EXPECT_NE(refusal(other).find("tolerance"), std::string::npos) << refusal(other);
    other = options;
    other.layers[0].resampling = Resampling::cubic;
    EXPECT_NE(refusal(other).find("resampling"), std::string::npos);
    other = options;
    other.layers.pop_back();
    EXPECT_NE(refusal(other).find("layers"), std::string::npos);
    const std::filesystem::path file = options.layers[0].files[0];
    std::ofstream(file, std::ios::app | std::ios::binary) << "x";
    EXPECT_NE(refusal(options).find("layers/0/files/0"), std::string::npos) << refusal(options);
    EXPECT_TRUE(std::filesystem::exists(workspace(options))) << "a refusal costs nothing";
}

TEST(Resume, NothingToResumeIsAnOrdinaryBuild) {
    const Scratch scratch;
    BuildOptions options = many_diamonds(scratch.folder);
    options.resume = true;
    EXPECT_EQ(build_repository(options).resumed_files, 0u);
}

TEST(Resume, TemporaryFilesGoWhereTheyAreSent) {
    const Scratch scratch;
    BuildOptions options = many_diamonds(scratch.folder);
    options.temp = scratch.folder / "elsewhere";
    ASSERT_TRUE(stopped_at(options, BuildStage::coding, 1000));
    EXPECT_FALSE(std::filesystem::exists(workspace(options)));
    std::uintmax_t bytes = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(options.temp))
        if (entry.is_regular_file()) bytes += entry.file_size();
    EXPECT_GT(bytes, 100000u);
    options.resume = true;
    const BuildReport report = build_repository(options);
    EXPECT_GT(report.resumed_files, 0u);
    EXPECT_LE(report.temporary_peak_bytes, report.plan.temporary_bytes) << "announced";
    EXPECT_TRUE(std::filesystem::is_empty(options.temp));
}

// A comma for the decimal point, and groups of digits.
struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
};

TEST(Reproducible, BytesDoNotDependOnTheLocale) {
    const Scratch scratch;
    BuildOptions options = many_diamonds(scratch.folder);
    options.layers[0].valid_range = {-12345.5, 9876.25};
    options.tolerance = 5.5;
    build_repository(options);
    const std::string expected = bytes_of(options.output);
    const std::string before = std::setlocale(LC_ALL, nullptr);
    const std::locale old = std::locale::global(std::locale(std::locale(), new Comma));
    for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"})
        if (std::setlocale(LC_NUMERIC, name) != nullptr) break;  // where one is installed
    build_repository(options);
    std::locale::global(old);
    std::setlocale(LC_ALL, before.c_str());
    EXPECT_TRUE(bytes_of(options.output) == expected);
}

TEST(Memory, TooLittleIsSaidSo) {
    const Scratch scratch;
    BuildOptions options = many_diamonds(scratch.folder);
    options.memory_bytes = kMegabyte;
    EXPECT_THROW(build_repository(options), Error);
    EXPECT_FALSE(std::filesystem::exists(options.output));
}

}  // namespace
}  // namespace carat::test
