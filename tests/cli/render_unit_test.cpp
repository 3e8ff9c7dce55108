// carat render: pictures, channels, statistics, refusals. Drawing is skipped where there is no Vulkan device.
#include <OpenImageIO/imageio.h>

#include "carat/globe/globe.hpp"
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
    const Outcome averaged = carat("render a.carat --eye 0,0,1e7 --aov color,depth --supersample 2 -o a.exr");
    EXPECT_EQ(averaged.exit, 2);
    EXPECT_NE(averaged.err.find("--supersample"), std::string::npos) << averaged.err;
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

// --supersample 2 is the picture of twice the size at twice the error, averaged.
TEST_F(Render, SupersampledPixelsAreAveraged) {
    CARAT_NEEDS_VULKAN();
    const std::string view = "render -q a.carat --eye 30,60,2e6 --samples 1 ";
    ASSERT_EQ(carat(view + "--size 32x20 --error 1 --spacing 3 --supersample 2 -o a.exr").exit, 0);
    ASSERT_EQ(carat(view + "--size 64x40 --error 2 --spacing 6 -o b.exr").exit, 0);
    const Image small = read_image(path("a.exr")), large = read_image(path("b.exr"));
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 32; ++x) {
            double sum = 0;
            for (const int k : {0, 1, 2, 3}) sum += large.at(2 * x + k % 2, 2 * y + k / 2, "G");
            EXPECT_NEAR(small.at(x, y, "G"), sum / 4, 2e-3) << x << ' ' << y;  // halves in the files
        }
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

double sum_of(const Image& image, int x, int y, const std::string& channel) {
    return image.at(x, y, channel) + static_cast<double>(image.at(x, y, channel + "_low"));
}

// The header's matrices bring every position to its own pixel; heights are those that carat query gives at
// the place, within the stated bound of the patch and what a slope of 1 makes of it.
TEST_F(Render, AovsAgreeWithEachOtherAndWithQueries) {
    CARAT_NEEDS_VULKAN();
    for (const char* view : {"--eye 30,60,2e6", "--eye 30,60,9000 --heading 40 --pitch -20"}) {
        SCOPED_TRACE(view);
        ASSERT_EQ(carat(std::string("render -q a.carat --size 47x31 --overwrite -o a.exr --aov "
                                    "depth,normal,position,height,latlon,error,level,source ") +
                        view)
                      .exit,
                  0);
        const Image image = read_image(path("a.exr"));
        const auto in = OIIO::ImageInput::open(path("a.exr").string());
        float camera[16], ndc[16];
        ASSERT_TRUE(in->spec().getattribute("worldtocamera", OIIO::TypeMatrix, camera));
        ASSERT_TRUE(in->spec().getattribute("worldtoscreen", OIIO::TypeMatrix, ndc));
        std::istringstream where(std::string(in->spec().get_string_attribute("carat:origin")));
        Vec3 origin{};
        for (double& x : origin) ASSERT_TRUE(where >> x);
        std::ostringstream places;
        places.precision(15);
        std::vector<std::array<double, 2>> heights;  // and bounds
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x) {
                if (image.at(x, y, "level.Y") < 0) {
                    EXPECT_EQ(image.at(x, y, "source.Y"), -1);
                    continue;
                }
                double p[4] = {0, 0, 0, 1}, to_camera[4] = {}, to_ndc[4] = {};
                for (int c = 0; c < 3; ++c) p[c] = image.at(x, y, std::string("position.") + "XYZ"[c]);
                for (int c = 0; c < 4; ++c)
                    for (int k = 0; k < 4; ++k) {
                        to_camera[c] += p[k] * static_cast<double>(camera[4 * k + c]);
                        to_ndc[c] += p[k] * static_cast<double>(ndc[4 * k + c]);
                    }
                ASSERT_NEAR(to_ndc[0] / to_ndc[3] * image.width, x + 0.5, 0.01);
                ASSERT_NEAR(to_ndc[1] / to_ndc[3] * image.height, y + 0.5, 0.01);
                // Position and place, each of two floats, name the same point of the body: to 0.1 mm
                // sideways.
                const Ellipsoid body = Ellipsoid::earth();
                Vec3 point = origin;
                for (std::size_t c = 0; c < 3; ++c) {
                    const float low = image.at(x, y, std::string("position_low.") + "XYZ"[c]);
                    ASSERT_LE(std::abs(static_cast<double>(low)), std::abs(p[c]) * 0x1p-24);
                    point[c] += p[c] + static_cast<double>(low);
                }
                const Geodetic place = geodetic(body.normal_height(point).normal);
                ASSERT_NEAR(place.latitude, sum_of(image, x, y, "latlon.lat"), 1e-9);
                ASSERT_NEAR(place.longitude, sum_of(image, x, y, "latlon.lon"), 1e-9);
                const double z = image.at(x, y, "Z");
                ASSERT_NEAR(to_camera[2], z, 1e-6 * z);
                ASSERT_LE(image.at(x, y, "error.pixels"), 1);
                places << sum_of(image, x, y, "latlon.lat") << ',' << sum_of(image, x, y, "latlon.lon")
                       << '\n';
                heights.push_back({image.at(x, y, "height.Y"), image.at(x, y, "error.metres")});
            }
        ASSERT_GT(heights.size(), 100u);
        std::istringstream answers(carat("query a.carat --no-header --points -", places.str()).out);
        std::string line;
        for (const auto& [height, bound] : heights) {
            ASSERT_TRUE(std::getline(answers, line));
            std::istringstream fields(line);
            std::string lat, lon, asked;
            std::getline(fields, lat, ',');
            std::getline(fields, lon, ',');
            std::getline(fields, asked, ',');
            ASSERT_NEAR(height, std::stod(asked), 1.5 * bound + 0.01) << line;
        }
    }
}

// A picture of the globe in two colours, without a georeference: west red, east blue.
TEST_F(Render, ColoursOfAFileOfTheirOwn) {
    {
        std::vector<std::uint8_t> pixels;
        for (int k = 0; k < 512 * 256; ++k)
            pixels.insert(pixels.end(), {static_cast<std::uint8_t>(k % 512 < 256 ? 220 : 20), 40,
                                         static_cast<std::uint8_t>(k % 512 < 256 ? 20 : 220)});
        const auto out = OIIO::ImageOutput::create(path("two.png").string());
        ASSERT_TRUE(out->open(path("two.png").string(), OIIO::ImageSpec(512, 256, 3, OIIO::TypeDesc::UINT8)));
        out->write_image(OIIO::TypeDesc::UINT8, pixels.data());
        out->close();
    }
    const Outcome built = carat("build --color two.png --color-tolerance 3/255 --json -o two.carat");
    ASSERT_EQ(built.exit, 0) << built.err;
    EXPECT_EQ(built.json().at("source_pixels"), 512 * 256);
    EXPECT_LE(built.json().at("planes").at("Y").at("max_error"), 2.5);
    const auto info = carat("info --json two.carat").json();
    EXPECT_EQ(info.at("attribute"), "colour");
    EXPECT_EQ(info.at("tolerance"), 3);
    EXPECT_EQ(carat("verify two.carat").exit, 0);
    const Outcome asked = carat("query two.carat --points - --no-header", "10,-90\n10,90\n");
    int red = 0, green = 0, blue = 0;
    ASSERT_EQ(std::sscanf(asked.out.c_str(), "10,-90,%d,%d,%d", &red, &green, &blue), 3) << asked.out;
    EXPECT_NEAR(red, 220, 4);
    EXPECT_NEAR(green, 40, 4);
    EXPECT_NEAR(blue, 20, 4);
    EXPECT_EQ(carat("render a.carat --eye 0,0,1e7 --colors moon --color a.carat -o no.png").exit, 1)
        << "relief is no colour";
    for (const char* both :
         {"build --color two.png --layer hills.tif --tolerance 1 -o b.carat",
          "build --color two.png --tolerance 1 -o b.carat", "build --layer hills.tif -o b.carat",
          "build --color two.png --color-tolerance 300 -o b.carat"})
        EXPECT_EQ(carat(both).exit, 2) << both;
    CARAT_NEEDS_VULKAN();
    ASSERT_EQ(
        carat("render -q a.carat --color two.carat --eye 0,0,2e7 --size 64x48 --ambient 1 -o a.png").exit, 0);
    const Image image = read_image(path("a.png"));
    EXPECT_NEAR(image.at(26, 24, "R"), 220 / 255.0, 0.03);
    EXPECT_NEAR(image.at(26, 24, "B"), 20 / 255.0, 0.03);
    EXPECT_NEAR(image.at(38, 24, "B"), 220 / 255.0, 0.03);

    // A flipped bit in the last plane.
    std::string bytes = contents(path("two.carat"));
    bytes[bytes.size() - 200] = static_cast<char>(bytes[bytes.size() - 200] ^ 4);
    std::ofstream(path("bad.carat"), std::ios::binary) << bytes;
    const Outcome bad = carat("verify bad.carat");
    EXPECT_EQ(bad.exit, 1) << bad.out;
    EXPECT_TRUE(contains(bad.out, "(Cg)")) << bad.out;
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
