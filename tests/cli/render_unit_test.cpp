// carat render: pictures, channels, statistics, refusals. Drawing is skipped where there is no Vulkan device.
#include <OpenImageIO/imageio.h>

#include "program.hpp"
#include "rasters.hpp"

namespace carat::test {
namespace {

struct Image {
    int width = 0, height = 0;
    std::vector<std::string> channels;
    std::vector<float> values;

    float at(int x, int y, const std::string& channel) const {
        for (std::size_t c = 0; c < channels.size(); ++c)
            if (channels[c] == channel)
                return values[static_cast<std::size_t>(y * width + x) * channels.size() + c];
        throw std::runtime_error("no channel " + channel);
    }
};

Image read_image(const fs::path& file) {
    const auto in = OIIO::ImageInput::open(file.string());
    if (!in) throw std::runtime_error(OIIO::geterror());
    const OIIO::ImageSpec& spec = in->spec();
    Image image{spec.width, spec.height, spec.channelnames, {}};
    image.values.resize(static_cast<std::size_t>(spec.width * spec.height * spec.nchannels));
    in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.values.data());
    return image;
}

class Render : public Program {
  protected:
    void SetUp() override {
        Program::SetUp();
        write_raster(path("hills.tif"), hills());
        ASSERT_EQ(carat("build -q --layer hills.tif --tolerance 5 -o a.carat").exit, 0);
    }
};

#define CARAT_NEEDS_VULKAN()                                                                \
    if (const Outcome r = carat("render -q a.carat --eye 0,0,1e7 --size 8x8 -o probe.png"); \
        r.exit != 0 && contains(r.err, "(unsupported)"))                                    \
    GTEST_SKIP() << r.err

TEST_F(Render, AnExistingPictureIsKeptUnlessOverwriteIsSaid) {
    std::ofstream(path("a.png")) << "precious";
    const Outcome r = carat("render a.carat --eye 0,0,1e7 -o a.png");
    EXPECT_EQ(r.exit, 2);
    EXPECT_TRUE(contains(r.err, "a.png: exists already")) << r.err;
    EXPECT_EQ(contents(path("a.png")), "precious");
}

TEST_F(Render, AovsNeedExr) {
    const Outcome r = carat("render a.carat --eye 0,0,1e7 --aov depth -o a.png");
    EXPECT_EQ(r.exit, 2);
    EXPECT_TRUE(contains(r.err, ".exr")) << r.err;
    const Outcome unknown = carat("render a.carat --eye 0,0,1e7 --aov warmth -o a.exr");
    EXPECT_EQ(unknown.exit, 2);
    EXPECT_TRUE(contains(unknown.err, "warmth")) << unknown.err;
}

TEST_F(Render, AGlobeOnItsBackground) {
    CARAT_NEEDS_VULKAN();
    const Outcome r =
        carat("render a.carat --eye -10,-20.5,1e7 --size 96x64 --background 255,0,255 -o a.png");
    ASSERT_EQ(r.exit, 0) << r.err;
    const Image image = read_image(path("a.png"));
    EXPECT_EQ(image.width, 96);
    EXPECT_EQ(image.height, 64);
    ASSERT_EQ(image.channels.size(), 3u);
    EXPECT_EQ(image.at(0, 0, "R"), 1);
    EXPECT_EQ(image.at(0, 0, "G"), 0);
    EXPECT_EQ(image.at(0, 0, "B"), 1);
    EXPECT_GT(image.at(48, 32, "G"), 0);
}

TEST_F(Render, ChannelsOfAovs) {
    CARAT_NEEDS_VULKAN();
    const Outcome r = carat(
        "render a.carat --eye 30,60,2e6 --size 33x21 --aov color,depth,normal,position,height,level -o "
        "a.exr");
    ASSERT_EQ(r.exit, 0) << r.err;
    const Image image = read_image(path("a.exr"));
    const double ground = carat("query --json a.carat 30 60").json().at("points").at(0).at("height_m");
    // Straight below the eye: the ground, at the eye's height less its own.
    EXPECT_NEAR(image.at(16, 10, "height.Y"), ground, 100);
    EXPECT_NEAR(image.at(16, 10, "Z"), 2e6 - ground, 2000);
    EXPECT_EQ(image.at(16, 10, "A"), 1);
    EXPECT_GE(image.at(16, 10, "level.Y"), 0);
    const double x = image.at(16, 10, "position.X"), y = image.at(16, 10, "position.Y"),
                 z = image.at(16, 10, "position.Z");
    EXPECT_NEAR(std::sqrt(x * x + y * y + z * z), 2e6 - ground, 2000);
    const double nx = image.at(16, 10, "normal.X"), ny = image.at(16, 10, "normal.Y"),
                 nz = image.at(16, 10, "normal.Z");
    EXPECT_NEAR(nx * nx + ny * ny + nz * nz, 1, 1e-3);
}

TEST_F(Render, StatisticsAreJson) {
    CARAT_NEEDS_VULKAN();
    const Outcome r =
        carat("render a.carat --eye 30,60,2e6 --size 64x48 --error 0.5 --stats s.json -o a.png");
    ASSERT_EQ(r.exit, 0) << r.err;
    const auto stats = nlohmann::json::parse(contents(path("s.json")));
    EXPECT_LE(stats.at("worst_error_px").get<double>(), 0.5);
    EXPECT_EQ(stats.at("patches").at("selected").get<int>(),
              stats.at("patches").at("drawn").get<int>() + stats.at("patches").at("culled_back").get<int>());
    EXPECT_EQ(stats.at("triangles").get<int>(), stats.at("patches").at("drawn").get<int>() * 64 * 64);
    EXPECT_GT(stats.at("read").at("bytes"), 0);
    EXPECT_LE(stats.at("read").at("share_of_file").get<double>(), 1);
    for (const char* key : {"selection", "decode", "build", "upload", "gpu", "readback"})
        EXPECT_TRUE(stats.at("milliseconds").contains(key)) << key;
}

// Of the whole globe: close by, finer patches can be fewer, for more of them are off the screen.
TEST_F(Render, ASmallerErrorDrawsMore) {
    CARAT_NEEDS_VULKAN();
    const auto triangles = [&](const std::string& error) {
        EXPECT_EQ(carat("render a.carat --eye 30,60,2e7 --size 64x48 --spacing 0 --overwrite --stats s.json "
                        "-o a.png --error " +
                        error)
                      .exit,
                  0);
        return nlohmann::json::parse(contents(path("s.json"))).at("triangles").get<std::uint64_t>();
    };
    EXPECT_LT(triangles("4"), triangles("0.0005"));
}

TEST_F(Render, TheSameCommandGivesTheSameBytes) {
    CARAT_NEEDS_VULKAN();
    const std::string view = "render a.carat --eye 30,60,5e5 --heading 200 --pitch -40 --size 64x48 ";
    ASSERT_EQ(carat(view + "-o a.png").exit, 0);
    ASSERT_EQ(carat(view + "--threads 1 -o b.png").exit, 0);
    EXPECT_EQ(contents(path("a.png")), contents(path("b.png")));
}

TEST_F(Render, AnEyeBelowTheGroundIsSaid) {
    CARAT_NEEDS_VULKAN();
    const Outcome r = carat("render a.carat --eye 0,0,-5 --pitch 0 --size 16x16 -o a.png");
    EXPECT_TRUE(contains(r.err, "below the ground")) << r.err;
}

// Noon and midnight at the eye's place: the sun of --time stands over it, or under it.
TEST_F(Render, TheSunStandsWhereTheTimeSays) {
    CARAT_NEEDS_VULKAN();
    const std::string view =
        "render -q a.carat --eye 0,0,2e7 --size 32x32 --ambient 0 --overwrite -o a.png --time ";
    ASSERT_EQ(carat(view + "2024-03-20T12:07:00Z").exit, 0);
    EXPECT_GT(read_image(path("a.png")).at(16, 16, "G"), 0.2);
    ASSERT_EQ(carat(view + "2024-03-20T00:07:00Z").exit, 0);
    EXPECT_EQ(read_image(path("a.png")).at(16, 16, "G"), 0);
    const Outcome both = carat(view + "2024-03-20T12:07:00Z --sun 0,90");
    EXPECT_EQ(both.exit, 2);
    const Outcome odd = carat(view + "yesterday");
    EXPECT_EQ(odd.exit, 2);
    EXPECT_TRUE(contains(odd.err, "yesterday")) << odd.err;
}

TEST_F(Render, ColoursFromAFile) {
    CARAT_NEEDS_VULKAN();
    std::ofstream(path("green.txt")) << "-9000 0 200 0\n9000 0 200 0\n";
    const std::string view =
        "render -q a.carat --eye 0,0,2e7 --size 32x32 --ambient 1 --overwrite -o a.png --colors ";
    ASSERT_EQ(carat(view + "green.txt").exit, 0);
    EXPECT_NEAR(read_image(path("a.png")).at(16, 16, "G"), 200 / 255.0, 0.005);
    EXPECT_EQ(read_image(path("a.png")).at(16, 16, "R"), 0);
    ASSERT_EQ(carat(view + "moon").exit, 0);
    EXPECT_GT(read_image(path("a.png")).at(16, 16, "R"), 0.2);
    const Outcome missing = carat(view + "nonesuch.cpt");
    EXPECT_NE(missing.exit, 0);
    EXPECT_TRUE(contains(missing.err, "nonesuch.cpt")) << missing.err;
}

TEST_F(Render, ToneIsForEightBitsAlone) {
    CARAT_NEEDS_VULKAN();
    const std::string view =
        "render -q a.carat --eye 0,0,2e7 --size 32x32 --ambient 1 --exposure 9 --overwrite ";
    ASSERT_EQ(carat(view + "--colors moon -o a.png").exit, 0);
    EXPECT_EQ(read_image(path("a.png")).at(16, 16, "R"), 1);
    ASSERT_EQ(carat(view + "--colors moon --tone reinhard -o a.png").exit, 0);
    EXPECT_LT(read_image(path("a.png")).at(16, 16, "R"), 1);
    ASSERT_EQ(carat(view + "--colors moon --tone reinhard -o a.exr").exit, 0);
    EXPECT_GT(read_image(path("a.exr")).at(16, 16, "R"), 1);
    EXPECT_EQ(carat(view + "--tone loud -o a.png").exit, 2);
}

TEST_F(Render, AnUnknownDeviceIsAnError) {
    CARAT_NEEDS_VULKAN();
    const Outcome r = carat("render a.carat --eye 0,0,1e7 --device nonesuch -o a.png");
    EXPECT_NE(r.exit, 0);
    EXPECT_TRUE(contains(r.err, "nonesuch")) << r.err;
    EXPECT_FALSE(fs::exists(path("a.png")));
}

}  // namespace
}  // namespace carat::test
