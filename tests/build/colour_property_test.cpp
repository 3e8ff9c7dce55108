// Colour files: the transform, the bound in RGB at every sample of every leaf, holes, planes that belong
// together, damage.
#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "carat/codec/colour.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/patch.hpp"
#include "carat/preprocess/build_colour.hpp"
#include "scratch.hpp"

namespace carat::test {
namespace {

using Pixels = std::array<int, 4>(int x, int y);  // red, green, blue, alpha

// Of the whole globe, without a georeference; with a fourth band where `alpha`.
void write_picture(const std::filesystem::path& file, int width, int height, bool alpha, Pixels pixels) {
    GDALAllRegister();
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    const int bands = alpha ? 4 : 3;
    char** options = alpha ? CSLAddString(nullptr, "ALPHA=YES") : nullptr;
    const GDALDatasetUniquePtr out(driver->Create(file.c_str(), width, height, bands, GDT_Byte, options));
    CSLDestroy(options);
    ASSERT_TRUE(out);
    for (int b = 0; b < bands; ++b) {
        std::vector<std::uint8_t> values;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                values.push_back(static_cast<std::uint8_t>(pixels(x, y)[static_cast<std::size_t>(b)]));
        ASSERT_EQ(out->GetRasterBand(b + 1)->RasterIO(GF_Write, 0, 0, width, height, values.data(), width,
                                                      height, GDT_Byte, 0, 0, nullptr),
                  CE_None);
    }
}

std::array<int, 4> speckled(int x, int y) {
    const auto hash = static_cast<unsigned>(x * 7919 + y * 104729) * 2654435761u;
    const auto noise = [&](int shift) { return static_cast<int>(hash >> shift & 63); };
    const int ramp = x * 190 / 512;
    return {ramp + noise(4), 190 - ramp + noise(11), y * 190 / 256 + noise(19), x < 256 ? 255 : 0};
}

ColourBuildOptions colours_of(const Scratch& scratch, bool alpha, int tolerance) {
    write_picture(scratch.folder / "picture.tif", 512, 256, alpha, speckled);
    ColourBuildOptions o;
    LayerOptions layer;
    layer.files = {(scratch.folder / "picture.tif").string()};
    layer.bounds = {-180, -90, 180, 90};
    layer.feather = 0;
    o.build.layers = {layer};
    o.build.mode = Mode::filtered;
    o.build.output = scratch.folder / "colours.carat";
    o.tolerance = tolerance;
    return o;
}

TEST(YCoCg, IsReversible) {
    for (int r = 0; r < 256; r += 3)
        for (int g = 0; g < 256; ++g)
            for (int b = 0; b < 256; b += 5) {
                const auto p = ycocg_of_rgb({r, g, b});
                const auto back = rgb_of_ycocg({p[0], p[1], p[2]});
                ASSERT_EQ(back, (std::array<std::uint8_t, 3>{static_cast<std::uint8_t>(r),
                                                             static_cast<std::uint8_t>(g),
                                                             static_cast<std::uint8_t>(b)}));
            }
}

TEST(YCoCg, ErrorsOfComponentsBoundThoseOfChannels) {
    std::mt19937 random(5);
    const auto from = [&](int low, int high) { return std::uniform_int_distribution(low, high)(random); };
    for (int tolerance = 0; tolerance <= 40; ++tolerance) {
        const ColourTolerances t = split_tolerance(tolerance);
        ASSERT_LE(t.rgb(), tolerance);
        int worst = 0;
        for (int k = 0; k < 20000; ++k) {
            const std::array<int, 3> rgb{from(0, 255), from(0, 255), from(0, 255)};
            auto p = ycocg_of_rgb(rgb);
            p[0] += from(-t.y, t.y);
            p[1] += from(-t.co, t.co);
            p[2] += from(-t.cg, t.cg);
            const auto back = rgb_of_ycocg({p[0], p[1], p[2]});
            for (std::size_t c = 0; c < 3; ++c) worst = std::max(worst, std::abs(back[c] - rgb[c]));
        }
        ASSERT_LE(worst, tolerance);
    }
}

// The source of a plane at a lattice point, as SourceStack gives it, rounded to the nearest integer, ties to
// even.
class Truth {
  public:
    explicit Truth(const ColourBuildOptions& o) {
        const auto base = ycocg_of_rgb({o.base_colour[0], o.base_colour[1], o.base_colour[2]});
        for (int k = 0; k < 3; ++k) {
            std::vector<LayerOptions> layers = o.build.layers;
            for (LayerOptions& layer : layers) layer.colour_component = k;
            sources_.emplace_back(layers, o.build.body, base[static_cast<std::size_t>(k)],
                                  std::size_t{64} << 20);
        }
    }
    std::array<std::uint8_t, 3> operator()(const LatticePoint& p) const {
        std::array<std::int32_t, 3> v{};
        for (std::size_t k = 0; k < 3; ++k)
            v[k] = static_cast<std::int32_t>(std::nearbyint(height_at_point(sources_[k], p)));
        return rgb_of_ycocg(v);
    }

  private:
    std::vector<SourceStack> sources_;
};

template <class Visit>
void leaves(const ColourRepository& file, const Half& half, const Visit& visit) {
    if (!file.refined(half.diamond)) return visit(half);
    for (const Half& child : child_halves(half)) leaves(file, child, visit);
}

void expect_bound(const ColourBuildOptions& o) {
    const auto file = ColourRepository::open(o.build.output);
    const Truth truth(o);
    const int cells = file->header().cells();
    std::vector<std::uint32_t> colours(half_vertex_count(cells));
    int worst = 0;
    std::uint64_t samples = 0;
    for (int face = 0; face < kFaces; ++face)
        for (const int side : {0, 1})
            leaves(*file, {root_diamond(face), side}, [&](const Half& half) {
                file->sample(half, colours);
                const HalfFrame frame = half_frame(half, cells);
                for (int r = 0; r <= cells; r += 3)
                    for (int c = 0; c <= r; c += 2) {
                        const int i = half.side == 0 ? r : c, j = half.side == 0 ? c : r;
                        const std::uint32_t got = colours[half_vertex_index(i, j)];
                        const auto want = truth(frame.vertex(i, j));
                        for (std::size_t k = 0; k < 3; ++k)
                            worst = std::max(worst,
                                             std::abs(static_cast<int>(got >> (8 * k) & 255) - int{want[k]}));
                        ++samples;
                    }
            });
    EXPECT_LE(worst, o.tolerance);
    EXPECT_GT(samples, 10000u);
    if (o.tolerance >= 8) {
        EXPECT_GT(worst, o.tolerance / 2) << "the tolerance is used";
    }
}

TEST(Colour, EveryChannelIsWithinTheToleranceAtEverySample) {
    for (const int tolerance : {0, 4, 10}) {
        SCOPED_TRACE(tolerance);
        const Scratch scratch;
        const ColourBuildOptions o = colours_of(scratch, false, tolerance);
        build_colour(o);
        expect_bound(o);
        EXPECT_EQ(ColourRepository::open(o.build.output)->tolerance(), tolerance);
    }
}

// The right half of the picture is transparent: there the base colour shows.
TEST(Colour, TransparentPixelsAreHoles) {
    const Scratch scratch;
    ColourBuildOptions o = colours_of(scratch, true, 2);
    o.base_colour = {10, 200, 30};
    build_colour(o);
    const auto file = ColourRepository::open(o.build.output);
    const auto hole = file->sample(lattice_position(direction(Geodetic{20, 90}))).rgb;
    EXPECT_NEAR(hole[0], 10, 2);
    EXPECT_NEAR(hole[1], 200, 2);
    EXPECT_NEAR(hole[2], 30, 2);
    expect_bound(o);
}

TEST(Colour, BytesDoNotDependOnThreads) {
    const Scratch scratch;
    ColourBuildOptions o = colours_of(scratch, false, 6);
    o.build.threads = 1;
    build_colour(o);
    const std::string one = bytes_of(o.build.output);
    o.build.threads = 3;
    o.build.overwrite = true;
    build_colour(o);
    EXPECT_EQ(one, bytes_of(o.build.output));
    for (const auto& entry : std::filesystem::directory_iterator(scratch.folder))
        EXPECT_TRUE(entry.path().filename() == "colours.carat" || entry.path().filename() == "picture.tif")
            << entry.path() << " was left";
}

// Every byte of the head, and the file's end.
// Interrupted in its second plane: the first is taken over, the bytes are the same. Complete already:
// accepted.
TEST(Colour, ResumesToTheSameBytes) {
    const auto contents = [](const std::filesystem::path& file) {
        std::ifstream in(file, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    const Scratch scratch;
    ColourBuildOptions o = colours_of(scratch, false, 9);
    build_colour(o);
    const std::filesystem::path output = o.build.output;
    const std::string expected = contents(output);
    std::filesystem::remove(output);

    int planes = 0;
    EXPECT_THROW(build_colour(o,
                              [&](const BuildProgress& p) {
                                  planes += p.stage == BuildStage::planning && p.done == 0 ? 1 : 0;
                                  return planes < 2;
                              }),
                 Error);
    EXPECT_FALSE(std::filesystem::exists(output));
    o.build.resume = true;
    const ColourBuildReport resumed = build_colour(o);
    EXPECT_TRUE(resumed.planes[0].already_complete);
    EXPECT_FALSE(resumed.planes[2].already_complete);
    EXPECT_TRUE(contents(output) == expected);
    build_colour(o);  // as if killed before its planes were gone
    EXPECT_TRUE(contents(output) == expected);
    o.tolerance = 20;
    EXPECT_THROW(build_colour(o), Error) << "another build's output";
    EXPECT_TRUE(contents(output) == expected);
    o.build.resume = false;
    EXPECT_THROW(build_colour(o), Error);
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(scratch.folder))
        files += entry.path() == output || entry.path().filename() == "picture.tif" ? 0 : 1;
    EXPECT_EQ(files, 0u) << "nothing is left lying about";
}

TEST(Colour, DamageIsAnError) {
    const Scratch scratch;
    const ColourBuildOptions o = colours_of(scratch, false, 10);
    build_colour(o);
    const std::string good = bytes_of(o.build.output);
    const auto expect_refused = [&](const std::string& bytes) {
        std::ofstream(o.build.output, std::ios::binary | std::ios::trunc) << bytes;
        EXPECT_THROW(ColourRepository::open(o.build.output), Error);
    };
    for (std::size_t k = 0; k < 48; ++k) {
        std::string bad = good;
        bad[k] = static_cast<char>(bad[k] ^ 0x10);
        expect_refused(bad);
    }
    expect_refused(good.substr(0, good.size() - 1));
    expect_refused(good.substr(0, 30));
    expect_refused(good + "x");
    std::ofstream(o.build.output, std::ios::binary | std::ios::trunc) << good;
    EXPECT_NO_THROW(ColourRepository::open(o.build.output));
}

}  // namespace
}  // namespace carat::test
