// Colour files of GDAL and GMT, and what is wrong with those that are refused.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "carat/globe/error.hpp"
#include "carat/vulkan/colour_table.hpp"
#include "carat/vulkan/picture.hpp"

namespace carat {

namespace {

class ColourFile : public ::testing::Test {
  protected:
    void TearDown() override { std::filesystem::remove(path_); }

    ColourTable read(const std::string& text) const {
        std::ofstream(path_) << text;
        return read_colours(path_);
    }
    // The sRGB bytes at a height on a latitude.
    static std::array<int, 3> bytes(const ColourTable& table, double height, double latitude = 0) {
        const auto linear = colour_at(table, latitude, height);
        std::array<int, 3> out{};
        for (std::size_t k = 0; k < 3; ++k)
            out[k] = static_cast<int>(std::lround(255 * srgb_encode(linear[k])));
        return out;
    }
    void expect_refused(const std::string& text, ErrorCode code, const std::string& part) const {
        SCOPED_TRACE(text);
        try {
            read(text);
            ADD_FAILURE() << "no error";
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), code);
            EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
            EXPECT_NE(std::string(e.what()).find(path_), std::string::npos) << e.what();
        }
    }

    const std::string path_ =
        (std::filesystem::temp_directory_path() / ("carat-colours-" + std::to_string(getpid()))).string();
};

TEST_F(ColourFile, GdalColourRelief) {
    const ColourTable table = read(
        "# comment\r\n3500   white\n2500,235:220:175\n50\t190 185 135 255\n700 240 250 150\nnv 0 0 0\n\n0 50 "
        "180 50\n");
    EXPECT_FALSE(table.sea_level);
    EXPECT_EQ(bytes(table, 3500), (std::array{255, 255, 255}));
    EXPECT_EQ(bytes(table, 2500), (std::array{235, 220, 175}));
    EXPECT_EQ(bytes(table, 25), (std::array{120, 183, 93})) << "half way from 0 to 50";
    EXPECT_EQ(bytes(table, -100), (std::array{50, 180, 50}));
}

TEST_F(ColourFile, GmtPalette) {
    const ColourTable table = read(
        "# COLOR_MODEL = RGB\n-8000 0 0 0 -4000 0 0 100 L\n-4000 0/0/100 0 100/100/255 ; sea\n"
        "0 #32b432 2000 240/250/150\n2000 240 4000 white\nB 0/0/0\nF 255 255 255\nN 128\n");
    ASSERT_TRUE(table.sea_level) << "the colour jumps at 0";
    EXPECT_EQ(*table.sea_level, 0);
    EXPECT_EQ(bytes(table, -6000), (std::array{0, 0, 50}));
    EXPECT_EQ(bytes(table, 0), (std::array{100, 100, 255})) << "at the level itself there is water";
    EXPECT_EQ(bytes(table, 1e-6), (std::array{50, 180, 50}));
    EXPECT_EQ(bytes(table, 1999.9999), (std::array{240, 250, 150}));
    EXPECT_EQ(bytes(table, 2000.0001), (std::array{240, 240, 240})) << "a jump elsewhere stays a jump";
}

TEST_F(ColourFile, AStretchedPaletteWithAHinge) {
    const std::string lines = "-1 0/0/0 0 0/0/200\n0 100/0/0 1 200/0/0\n";
    const ColourTable hinged = read("# RANGE = -10000/5000\n# HARD_HINGE\n" + lines);
    EXPECT_EQ(bytes(hinged, -5000), (std::array{0, 0, 100}));
    EXPECT_EQ(bytes(hinged, 2500), (std::array{150, 0, 0}));
    const ColourTable plain = read("# RANGE = 1000/3000\n0 black 1 200/200/200\n");
    EXPECT_EQ(bytes(plain, 2000), (std::array{100, 100, 100}));
}

TEST_F(ColourFile, BandsOfLatitude) {
    const ColourTable table =
        read("latitude 60\n0 100 0 0\n10 200 0 0\nlatitude -60\n0 0 0 100\n10 0 0 200\n");
    ASSERT_EQ(table.land.size(), 2u);
    EXPECT_EQ(bytes(table, 5, -75), (std::array{0, 0, 150}));
    EXPECT_EQ(bytes(table, 5, 90), (std::array{150, 0, 0}));
    EXPECT_EQ(bytes(table, 5, 0), (std::array{75, 0, 75}));
}

TEST_F(ColourFile, WhatIsRefused) {
    expect_refused("", ErrorCode::corrupt, "no line");
    expect_refused("0 1 2\n", ErrorCode::corrupt, "line 1");
    expect_refused("0 1 2 3\n10 1 2 256\n", ErrorCode::corrupt, "line 2");
    expect_refused("0 1 2 3\nten 1 2 3\n", ErrorCode::corrupt, "\"ten\"");
    expect_refused("0 1 2 3\n10 chartreux\n", ErrorCode::corrupt, "chartreux");
    expect_refused("0% 1 2 3\n100% 4 5 6\n", ErrorCode::unsupported, "percent");
    expect_refused("# COLOR_MODEL = HSV\n0 0 1 1 1 1 1 1\n", ErrorCode::unsupported, "HSV");
    expect_refused("10 1 2 3 5 1 2 3\n", ErrorCode::corrupt, "ascend");
    expect_refused("latitude 91\n0 1 2 3\n", ErrorCode::corrupt, "latitude");
    expect_refused("0 1 2 3\n", ErrorCode::usage, "two stops");
    std::filesystem::remove(path_);
    EXPECT_THROW(read_colours(path_), Error);
}

}  // namespace

}  // namespace carat
