#pragma once
// Real elevation data for tests. They lie outside the repository: in the folder that the environment variable
// CARAT_TEST_DATA names, by default ../shared/data beside the source tree. A test that needs a file begins
// with
//     CARAT_NEEDS_DATA("earth_5min.tif");
// and is skipped, visibly, where the file is not there.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace carat::test {

inline std::filesystem::path data_folder() {
    const char* named = std::getenv("CARAT_TEST_DATA");
    return named != nullptr && *named != '\0' ? std::filesystem::path(named)
                                              : std::filesystem::path(CARAT_SOURCE_DIR) / "../shared/data";
}

inline std::string data_file(const std::string& name) { return (data_folder() / name).string(); }

}  // namespace carat::test

#define CARAT_NEEDS_DATA(name)                                  \
    if (!std::filesystem::exists(carat::test::data_file(name))) \
    GTEST_SKIP() << "no " << carat::test::data_file(name) << " (CARAT_TEST_DATA names another folder)"
