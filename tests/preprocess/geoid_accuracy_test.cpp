// Geoid heights against GeographicLib and against a formula; images through OpenImageIO.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <GeographicLib/Geoid.hpp>
#include <fstream>

#include "carat/globe/error.hpp"
#include "raster_maker.hpp"
#include "support/test_data.hpp"

namespace carat::test {
namespace {

std::string flat(const Folder& folder, double height) {
    RasterSpec s{360, 180};
    s.transform = {-180, 1, 0, 90, 0, -1};
    return write_raster(folder.file("flat.tif"), s, [=](double, double) { return height; });
}

TEST(GeoidAccuracy, PgmAgreesWithGeographicLib) {
    CARAT_NEEDS_DATA("egm96-15.pgm");
    const Folder folder;
    LayerOptions options = layer_of(flat(folder, 100));
    options.geoid = data_file("egm96-15.pgm");
    const SourceStack stack = stack_of({options});
    const GeographicLib::Geoid geoid("egm96-15", data_folder().string());
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> lat(-90, 90), lon(-180, 180);
    for (int i = 0; i < 5000; ++i) {
        const double la = lat(random), lo = lon(random);
        ASSERT_NEAR(stack.sample(at(la, lo)).height, 100 + geoid(la, lo), 1e-6);
    }
    EXPECT_EQ(stack.layers()[0].geoid, options.geoid);
}

TEST(GeoidAccuracy, RasterIsAddedToLayerAndBase) {
    const Folder folder;
    RasterSpec g{36, 18};
    g.transform = {-180, 10, 0, 90, 0, -10};
    const std::string geoid =
        write_raster(folder.file("geoid.tif"), g, [](double, double v) { return 90 - 10 * v; });
    RasterSpec s{10, 10};
    LayerOptions options =
        layer_of(write_raster(folder.file("small.tif"), s, [](double, double) { return 1000; }));
    options.geoid = geoid;
    const SourceStack stack = stack_of({options});
    EXPECT_NEAR(stack.sample(at(-5, 5)).height, 1000 - 5, 1e-9);
    EXPECT_EQ(stack.sample(at(-5, 5)).layer, 0);
    EXPECT_NEAR(stack.sample(at(47, 5)).height, kBase + 47, 1e-9);
    EXPECT_EQ(stack.sample(at(47, 5)).layer, kBaseLayer);
}

TEST(GeoidAccuracy, WhereTheGeoidHasAHoleTheLayerHasOne) {
    const Folder folder;
    RasterSpec g{36, 18};
    g.transform = {-180, 10, 0, 90, 0, -10};
    g.nodata = -1;
    LayerOptions options = layer_of(flat(folder, 100));
    options.geoid = write_raster(folder.file("g.tif"), g, [](double u, double) { return u < 18 ? -1 : 30; });
    const SourceStack stack = stack_of({options});
    EXPECT_EQ(stack.sample(at(40, 50)).height, 130);
    EXPECT_EQ(stack.sample(at(40, -50)).layer, kBaseLayer);
}

TEST(GeoidAccuracy, BadGeoidsAreNamed) {
    const Folder folder;
    LayerOptions options = layer_of(flat(folder, 100));
    options.geoid = folder.file("none.pgm");
    EXPECT_EQ(refusal({options}, "none.pgm"), ErrorCode::io);
    std::ofstream(folder.file("bad.pgm")) << "P5\n# not a geoid\n1 1\n65535\n";
    options.geoid = folder.file("bad.pgm");
    EXPECT_EQ(refusal({options}, "bad.pgm"), ErrorCode::io);
    options.geoid = folder.file("none.tif");
    EXPECT_EQ(refusal({options}, "none.tif"), ErrorCode::io);
}

// An OpenEXR image: a format that Debian's GDAL does not read.
TEST(ImageSource, ExrWithBounds) {
    const Folder folder;
    const std::string path = folder.file("heights.exr");
    constexpr int kWidth = 300, kHeight = 150;
    std::vector<float> pixels;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            pixels.push_back(static_cast<float>(x) - 3 * static_cast<float>(y) + 0.25f);
    {
        OIIO::ImageSpec spec(kWidth, kHeight, 1, OIIO::TypeDesc::FLOAT);
        const auto out = OIIO::ImageOutput::create(path);
        ASSERT_TRUE(out && out->open(path, spec));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
        out->close();
    }
    LayerOptions options = layer_of(path);
    options.bounds = {{10, 20, 40, 35}};
    const SourceStack stack = stack_of({options});
    EXPECT_EQ(stack.layers()[0].files[0].driver, "OpenImageIO:openexr");
    for (double u = 2; u < kWidth - 2; u += 7.3)
        for (double v = 2; v < kHeight - 2; v += 5.1)
            ASSERT_NEAR(stack.sample(at(35 - v / 10, 10 + u / 10)).height, (u - 0.5) - 3 * (v - 0.5) + 0.25,
                        1e-6);
    options.bounds.reset();
    EXPECT_EQ(refusal({options}, "heights.exr"), ErrorCode::io);
}

TEST(ImageSource, SixteenBitPngWithBounds) {
    const Folder folder;
    RasterSpec s{20, 10};
    s.type = GDT_UInt16;
    s.georeferenced = false;
    s.epsg = 0;
    const std::string tiff =
        write_raster(folder.file("x.tif"), s, [](double u, double) { return 60000 + std::floor(u); });
    GDALDataset* in = GDALDataset::Open(tiff.c_str());
    const std::string path = folder.file("x.png");
    GDALClose(GetGDALDriverManager()->GetDriverByName("PNG")->CreateCopy(path.c_str(), in, false, nullptr,
                                                                         nullptr, nullptr));
    GDALClose(in);
    LayerOptions options = layer_of(path, Resampling::nearest);
    options.bounds = {{-180, -90, 180, 90}};
    EXPECT_EQ(stack_of({options}).sample(at(0, 1)).height, 60010);
}

TEST(Geoid, HeightsThatAreEllipsoidalAlreadyAreRefused) {
    const Folder folder;
    RasterSpec spec;
    spec.epsg = 4979;  // WGS 84 with ellipsoidal heights
    LayerOptions layer =
        layer_of(write_raster(folder.file("ellipsoidal.tif"), spec, [](double, double) { return 7.0; }));
    RasterSpec grid{36, 18, {-180, 10, 0, 90, 0, -10}};
    layer.geoid = write_raster(folder.file("geoid.tif"), grid, [](double, double) { return 40.0; });
    EXPECT_EQ(refusal({layer}, "ellipsoidal.tif"), ErrorCode::usage);
    layer.geoid.clear();
    EXPECT_EQ(refusal({layer}, "ellipsoidal.tif"), std::nullopt);
}

}  // namespace
}  // namespace carat::test
