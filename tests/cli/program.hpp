// Runs the program in a process of its own, in a scratch folder.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace carat::test {

namespace fs = std::filesystem;

inline std::string contents(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
}

struct Outcome {
    int exit = -1;  // -1: ended by a signal
    std::string out, err;

    nlohmann::json json() const { return nlohmann::json::parse(out); }
};

inline bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

// A folder of its own for each test; carat runs in it.
class Program : public testing::Test {
  protected:
    void SetUp() override {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::temp_directory_path() / ("carat-" + std::to_string(getpid()) + "-" + info->name());
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    fs::path path(const std::string& name) const { return folder_ / name; }

    // arguments: as typed in a shell.
    Outcome carat(const std::string& arguments, const std::string& input = "") const {
        std::ofstream(path("stdin.txt")) << input;
        const std::string command = "cd '" + folder_.string() + "' && '" CARAT_PROGRAM "' " + arguments +
                                    " <stdin.txt >stdout.txt 2>stderr.txt";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(path("stdout.txt")),
                contents(path("stderr.txt"))};
    }

  private:
    fs::path folder_;
};

}  // namespace carat::test
