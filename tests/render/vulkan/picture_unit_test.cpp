// Pictures written and read again through OpenImageIO.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "carat/globe/error.hpp"
#include "carat/vulkan/picture.hpp"

namespace carat {

namespace {

namespace fs = std::filesystem;

class PictureFile : public ::testing::Test {
  protected:
    fs::path folder;
    void SetUp() override {
        folder =
            fs::temp_directory_path() /
            ("carat-picture-" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
        fs::remove_all(folder);
        fs::create_directories(folder);
    }
    void TearDown() override { fs::remove_all(folder); }
    std::string path(const char* name) const { return (folder / name).string(); }
    std::size_t files() const {
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }
};

Picture gradient(int width, int height, std::vector<std::string> channels) {
    Picture p{width, height, std::move(channels), {}, {}};
    const std::size_t count =
        static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * p.channels.size();
    for (std::size_t i = 0; i < count; ++i)
        p.values.push_back(static_cast<float>(i) / static_cast<float>(count));
    return p;
}

std::unique_ptr<OIIO::ImageInput> open(const std::string& path) {
    auto in = OIIO::ImageInput::open(path);
    EXPECT_TRUE(in) << OIIO::geterror();
    return in;
}

TEST(Shrunk, PixelsAreMeansOfSquaresAndWhatIsLeftOverIsDropped) {
    const Picture p = gradient(7, 5, {"R", "Z"});
    const Picture half = shrunk(p, 2);
    ASSERT_EQ(half.width, 3);
    ASSERT_EQ(half.height, 2);
    ASSERT_EQ(half.values.size(), 12u);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 3; ++x)
            for (int c = 0; c < 2; ++c)
                EXPECT_FLOAT_EQ(half.at(x, y)[c],
                                (p.at(2 * x, 2 * y)[c] + p.at(2 * x + 1, 2 * y)[c] +
                                 p.at(2 * x, 2 * y + 1)[c] + p.at(2 * x + 1, 2 * y + 1)[c]) /
                                    4);
    EXPECT_EQ(shrunk(p, 1).values, p.values);
}

TEST(Srgb, IsItsOwnInverseAndMeetsTheStandard) {
    for (int i = 0; i <= 255; ++i) {
        const float e = static_cast<float>(i) / 255;
        EXPECT_NEAR(srgb_encode(srgb_decode(e)), e, 1e-6);
    }
    EXPECT_NEAR(srgb_encode(0.18f), 0.46135613f, 1e-6);
    EXPECT_NEAR(srgb_encode(0.0031308f), 0.04045f, 1e-5);
    EXPECT_EQ(srgb_encode(-1), 0);
    EXPECT_EQ(srgb_encode(7), 1);
    EXPECT_EQ(srgb_encode(NAN), 0);
}

TEST(ToneMapping, KeepsOrderAndBlackAndStaysBelowWhite) {
    for (const Tone tone : {Tone::none, Tone::reinhard, Tone::aces}) {
        Picture p{64, 1, {"R", "G", "B", "A"}, {}, {}};
        for (int x = 0; x < 64; ++x) {
            const float v = 0.125f * static_cast<float>(x);
            p.values.insert(p.values.end(), {v, v, v, 9});
        }
        tone_map(p, tone);
        EXPECT_EQ(p.at(0, 0)[0], 0);
        for (int x = 1; x < 64; ++x) {
            EXPECT_GE(p.at(x, 0)[1], p.at(x - 1, 0)[1]) << x;
            if (tone != Tone::none) {
                EXPECT_LE(p.at(x, 0)[1], 1) << x;
            }
            EXPECT_EQ(p.at(x, 0)[3], 9) << "coverage is no light";
        }
    }
    Picture p{1, 1, {"R", "G", "B"}, {4, 4, 4}, {}};
    tone_map(p, Tone::reinhard);
    EXPECT_NEAR(p.values[0], 1, 1e-6) << "white at 4";
    p.values = {1, 1, 1};
    tone_map(p, Tone::aces);
    EXPECT_NEAR(p.values[0], 2.54 / 3.16, 1e-6);
    Picture depth{1, 1, {"Z"}, {4}, {}};
    EXPECT_THROW(tone_map(depth, Tone::aces), Error);
}

TEST_F(PictureFile, PngIsEightBitSrgb) {
    const Picture p = gradient(31, 7, {"R", "G", "B"});
    write_picture(path("a.png"), p);
    EXPECT_EQ(files(), 1u) << "no temporary file is left";
    auto in = open(path("a.png"));
    ASSERT_TRUE(in);
    EXPECT_EQ(in->spec().width, 31);
    EXPECT_EQ(in->spec().height, 7);
    EXPECT_EQ(in->spec().nchannels, 3);
    EXPECT_EQ(in->spec().format, OIIO::TypeDesc::UINT8);
    std::vector<std::uint8_t> bytes(p.values.size());
    ASSERT_TRUE(in->read_image(0, 0, 0, -1, OIIO::TypeDesc::UINT8, bytes.data()));
    for (std::size_t i = 0; i < bytes.size(); ++i)
        ASSERT_EQ(bytes[i], std::lround(255 * srgb_encode(p.values[i])));
}

TEST_F(PictureFile, PngKeepsColoursWhereAlphaIsZero) {
    write_picture(path("a.png"), {1, 1, {"R", "G", "B", "A"}, {1, 0, 1, 0}});
    auto in = open(path("a.png"));
    ASSERT_TRUE(in);
    in->close();
    OIIO::ImageSpec config;
    config["oiio:UnassociatedAlpha"] = 1;
    in = OIIO::ImageInput::open(path("a.png"), &config);
    std::array<std::uint8_t, 4> bytes{};
    ASSERT_TRUE(in->read_image(0, 0, 0, -1, OIIO::TypeDesc::UINT8, bytes.data()));
    EXPECT_EQ(bytes, (std::array<std::uint8_t, 4>{255, 0, 255, 0}));
}

TEST_F(PictureFile, ExrKeepsNamesAndPrecision) {
    const Picture p = gradient(20, 11, {"R", "G", "B", "A", "Z"});
    write_picture(path("a.exr"), p);
    auto in = open(path("a.exr"));
    ASSERT_TRUE(in);
    EXPECT_EQ(in->spec().channelnames, p.channels);
    EXPECT_EQ(in->spec().channelformat(0), OIIO::TypeDesc::HALF);
    EXPECT_EQ(in->spec().channelformat(4), OIIO::TypeDesc::FLOAT);
    std::vector<float> values(p.values.size());
    ASSERT_TRUE(in->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, values.data()));
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (i % 5 == 4) {
            ASSERT_EQ(values[i], p.values[i]);
        } else {
            ASSERT_NEAR(values[i], p.values[i], p.values[i] * 0x1p-11 + 1e-7);
        }
    }
    write_picture(path("b.exr"), p, PixelType::float32);
    auto full = open(path("b.exr"));
    ASSERT_TRUE(full);
    ASSERT_TRUE(full->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, values.data()));
    EXPECT_EQ(values, p.values);
}

TEST_F(PictureFile, ErrorsAreTypedAndLeaveNothingBehind) {
    const Picture p = gradient(4, 4, {"R", "G", "B"});
    const auto code = [](const std::string& file, const Picture& picture) {
        try {
            write_picture(file, picture);
        } catch (const Error& e) {
            EXPECT_NE(std::string(e.what()).find(file), std::string::npos) << e.what();
            return e.code();
        }
        ADD_FAILURE() << "no error for " << file;
        return ErrorCode::corrupt;
    };
    EXPECT_EQ(code(path("no/such/folder/a.png"), p), ErrorCode::io);
    EXPECT_EQ(code(path("a.nonsense"), p), ErrorCode::usage);
    EXPECT_EQ(code(path("a.png"), Picture{}), ErrorCode::usage);
    EXPECT_EQ(code(path("a.png"), Picture{4, 4, {"R"}, {1, 2}, {}}), ErrorCode::usage);
    fs::create_directories(folder / "taken.png");
    EXPECT_EQ(code(path("taken.png"), p), ErrorCode::io);
    EXPECT_EQ(files(), 1u);
}

}  // namespace

}  // namespace carat
