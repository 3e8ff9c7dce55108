// Colours on the relief's cut: refined where either asks, virtually where only colours do, and every vertex
// with its colour.
#include <gdal_priv.h>
#include <gtest/gtest.h>

#include "build/scratch.hpp"
#include "carat/globe/bounds.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/patch.hpp"
#include "carat/preprocess/build_colour.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/refiner.hpp"

namespace carat::test {
namespace {

class Drape : public testing::Test {
  protected:
    // A picture of the globe and its colour file, finer than the relief.
    std::shared_ptr<const ColourRepository> colours(int width) {
        GDALAllRegister();
        const auto path = scratch.folder / "picture.tif";
        {
            GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
            const GDALDatasetUniquePtr out(
                driver->Create(path.c_str(), width, width / 2, 3, GDT_Byte, nullptr));
            std::vector<std::uint8_t> row(static_cast<std::size_t>(width));
            for (int b = 1; b <= 3; ++b)
                for (int y = 0; y < width / 2; ++y) {
                    for (int x = 0; x < width; ++x)
                        row[static_cast<std::size_t>(x)] =
                            static_cast<std::uint8_t>((x * b * 37 + y * 91) % 256);
                    EXPECT_EQ(out->GetRasterBand(b)->RasterIO(GF_Write, 0, y, width, 1, row.data(), width, 1,
                                                              GDT_Byte, 0, 0, nullptr),
                              CE_None);
                }
        }
        ColourBuildOptions o;
        LayerOptions layer;
        layer.files = {path.string()};
        layer.bounds = {-180, -90, 180, 90};
        o.build.layers = {layer};
        o.build.mode = Mode::filtered;
        o.build.output = scratch.folder / "colours.carat";
        build_colour(o);
        return ColourRepository::open(o.build.output);
    }

    std::shared_ptr<const Repository> relief(int width) {
        BuildOptions build = synthetic_build(synth::Kind::earth, scratch.folder, width);
        build.measure = false;
        build_repository(build);
        return Repository::open(build.output);
    }

    const Scratch scratch;
};

TEST_F(Drape, RefinesWhereEitherAsksAndColoursEveryVertex) {
    const auto ground = relief(256);
    const auto colour = colours(2048);
    const Ellipsoid body = ground->header().ellipsoid();
    const View view(body, {{20, -40}, 1.5e6, 30, -60, 0, 50, 600, 400});
    const DrawList plain = converged_cut(*ground, view, 1, 1.5);
    const DrawList draped = converged_cut(*ground, view, 1, 1.5, colour);
    EXPECT_GT(draped.counters.virtual_refined, plain.counters.virtual_refined);
    EXPECT_GE(draped.counters.decoded, plain.counters.decoded);  // more where conformity wants it

    const Visibility visibility(view, body, ground->header().min_height * ground->header().quantum,
                                ground->header().max_height * ground->header().quantum, 1);
    const int cells = ground->header().cells();
    std::vector<std::uint32_t> expected(half_vertex_count(cells));
    std::size_t finest = 0;
    for (const auto& mesh : draped.meshes) {
        ASSERT_EQ(mesh->colours.size(), mesh->vertices.size());
        colour->sample(mesh->half, expected);
        ASSERT_EQ(mesh->colours, expected);
        if (!colour->refined(mesh->half.diamond)) continue;
        ++finest;
        // Left as it is: close enough, or off the screen at its own bounds.
        const double spacing = sample_spacing(body, mesh->half.diamond, cells);
        const HalfVolume volume =
            half_volume(body, mesh->half, ground->header().min_height * ground->header().quantum,
                        ground->header().max_height * ground->header().quantum, 1);
        EXPECT_LE(visibility.screen_spacing(volume, spacing), 4) << to_string(mesh->half.diamond);
    }
    EXPECT_GT(finest, 0u);
    for (const auto& mesh : plain.meshes) EXPECT_TRUE(mesh->colours.empty());
}

// From frame to frame the same cut with the same colours.
TEST_F(Drape, TheRefinerConvergesToTheSame) {
    const auto ground = relief(256);
    const auto colour = colours(1024);
    const View view(ground->header().ellipsoid(), {{20, -40}, 2e6, 30, -60, 0, 50, 400, 250});
    RefinerOptions options;
    options.colour = colour;
    Refiner refiner(ground, options);
    const RefinedFrame frame = refiner.frame(view, {1, 1.5});
    ASSERT_TRUE(frame.converged);
    const DrawList list = converged_cut(*ground, view, 1, 1.5, colour);
    ASSERT_EQ(frame.draw.size(), list.meshes.size());
    for (std::size_t k = 0; k < list.meshes.size(); ++k) {
        ASSERT_EQ(frame.draw[k]->half, list.meshes[k]->half);
        ASSERT_EQ(frame.draw[k]->colours, list.meshes[k]->colours);
    }
}

TEST_F(Drape, ColoursOfAnotherBodyAreRefused) {
    const auto ground = relief(128);
    const auto colour = colours(128);
    RepositoryHeader moon = ground->header();
    moon.body_a = moon.body_b = 1737400;
    EXPECT_THROW(check_colours_fit(*colour, moon), Error);
    EXPECT_NO_THROW(check_colours_fit(*colour, ground->header()));
}

}  // namespace
}  // namespace carat::test
