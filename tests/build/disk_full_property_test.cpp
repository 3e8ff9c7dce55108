// A disk that fills up while a build runs: the error says what was needed, and nothing done is lost.
#include <gtest/gtest.h>

#include "carat/globe/error.hpp"
#include "scratch.hpp"

namespace carat::test {
namespace {

namespace fs = std::filesystem;

BuildOptions small_build(const fs::path& folder) {
    BuildOptions options = synthetic_build(synth::Kind::earth, folder, 256);
    options.log2_cells = 4;
    options.overwrite = true;
    options.measure = false;
    return options;
}

// Once `stage` begins, writing `file` meets the kernel's own ENOSPC: it is a link to /dev/full. Returns the
// message.
std::string fails_at(const BuildOptions& options, BuildStage stage, const fs::path& file) {
    try {
        build_repository(options, [&](const BuildProgress& p) {
            if (p.stage == stage && !fs::is_symlink(file)) fs::create_symlink("/dev/full", file);
            return true;
        });
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::io) << e.what();
        return e.what();
    }
    ADD_FAILURE() << "built on a full disk";
    return "";
}

void expect_explained(const std::string& message) {
    for (const char* part : {"no space left", "need", " MiB", "are free", "--resume"})
        EXPECT_NE(message.find(part), std::string::npos) << part << ": " << message;
}

class FullDisk : public testing::Test {
  protected:
    void SetUp() override {
        if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
        options_ = small_build(scratch_.folder);
        build_repository(options_);
        expected_ = bytes_of(options_.output);
        fs::remove(options_.output);
    }
    void expect_resumed() {
        EXPECT_FALSE(fs::exists(options_.output));
        options_.resume = true;
        const BuildReport report = build_repository(options_);
        EXPECT_GT(report.resumed_files, 0u) << "nothing lost";
        EXPECT_TRUE(bytes_of(options_.output) == expected_);
        EXPECT_FALSE(fs::exists(options_.output.string() + ".build"));
    }

    Scratch scratch_;
    BuildOptions options_;
    std::string expected_;
};

TEST_F(FullDisk, TemporaryFiles) {
    const fs::path folder = options_.output.string() + ".build";
    expect_explained(fails_at(options_, BuildStage::coding, folder / "facts-4-0.unfinished"));
    expect_resumed();
}

TEST_F(FullDisk, TheOutput) {
    const fs::path partial = options_.output.string() + ".partial";
    expect_explained(fails_at(options_, BuildStage::summarising, partial));
    EXPECT_FALSE(fs::exists(partial));
    expect_resumed();
}

}  // namespace
}  // namespace carat::test
