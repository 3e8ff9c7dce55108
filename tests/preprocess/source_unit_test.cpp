// Layers, holes, kernels at holes and borders, options, information.
#include <gtest/gtest.h>

#include "carat/globe/error.hpp"
#include "raster_maker.hpp"

namespace carat::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// 1 degree samples: sample (x, y) of a raster with this transform lies at latitude -y - 0.5, longitude x +
// 0.5.
Vec3 pixel(double u, double v) { return at(-v, u); }

TEST(SourceUnit, NoLayersGiveTheBaseHeight) {
    const SourceStack stack = stack_of(std::vector<LayerOptions>{});
    EXPECT_EQ(stack.sample(at(1, 2)).height, kBase);
    EXPECT_EQ(stack.sample(at(1, 2)).layer, kBaseLayer);
    EXPECT_EQ(stack.finest_spacing(root_diamond(0)), kInf);
}

TEST(SourceUnit, EveryKindOfHoleFallsThrough) {
    const Folder folder;
    RasterSpec s{8, 8};
    const Value holed = [](double u, double) {
        const int x = static_cast<int>(u);
        return x == 1   ? kNaN
               : x == 2 ? kInf
               : x == 3 ? -kInf
               : x == 4 ? -9999
               : x == 5 ? 1e30
               : x == 6 ? 777
                        : 5;
    };
    s.nodata = -9999;
    LayerOptions top = layer_of(write_raster(folder.file("top.tif"), s, holed), Resampling::nearest);
    top.valid_range = {{-500, 9000}};
    top.nodata = 777;
    s.nodata.reset();
    const LayerOptions below =
        layer_of(write_raster(folder.file("below.tif"), s, [](double u, double) { return u < 3 ? 1 : kNaN; }),
                 Resampling::nearest);
    const SourceStack stack = stack_of({top, below});
    const auto layer = [&](int x) { return stack.sample(pixel(x + 0.5, 3.5)).layer; };
    EXPECT_EQ(layer(0), 0);
    EXPECT_EQ(layer(1), 1);
    EXPECT_EQ(layer(2), 1);
    for (const int x : {3, 4, 5, 6}) EXPECT_EQ(layer(x), kBaseLayer) << x;
    EXPECT_EQ(layer(7), 0);
    EXPECT_EQ(stack.layers()[0].valid_samples, 2u * 8);
    EXPECT_EQ(stack.layers()[1].valid_samples, 3u * 8);
    EXPECT_EQ(stack.layers()[1].samples, 64u);
}

TEST(SourceUnit, IntegerExtremesAreValuesWithoutATag) {
    const Folder folder;
    RasterSpec s{4, 4};
    s.type = GDT_Int16;
    const std::string path =
        write_raster(folder.file("x.tif"), s, [](double u, double) { return u < 2 ? -32768 : 32767; });
    const SourceStack stack = stack_of(path, Resampling::nearest);
    EXPECT_EQ(stack.sample(pixel(0.5, 0.5)).height, -32768);
    EXPECT_EQ(stack.sample(pixel(3.5, 0.5)).height, 32767);
    LayerOptions option = layer_of(path, Resampling::nearest);
    option.nodata = -32768;
    EXPECT_EQ(stack_of({option}).sample(pixel(0.5, 0.5)).layer, kBaseLayer);
    option.nodata = -32768.5;  // equals no sample
    EXPECT_EQ(stack_of({option}).sample(pixel(0.5, 0.5)).layer, 0);
}

TEST(SourceUnit, MaskBandsAreHoles) {
    const Folder folder;
    RasterSpec s{4, 4};
    s.type = GDT_Byte;
    const std::string path = write_raster(folder.file("m.tif"), s, [](double, double) { return 7; });
    GDALDataset* d = GDALDataset::Open(path.c_str(), GDAL_OF_UPDATE);
    ASSERT_EQ(d->CreateMaskBand(GMF_PER_DATASET), CE_None);
    std::vector<std::uint8_t> mask(16, 255);
    mask[5] = 0;
    ASSERT_EQ(d->GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Write, 0, 0, 4, 4, mask.data(), 4, 4, GDT_Byte,
                                                           0, 0, nullptr),
              CE_None);
    GDALClose(d);
    const SourceStack stack = stack_of(path, Resampling::nearest);
    EXPECT_EQ(stack.sample(pixel(1.5, 1.5)).layer, kBaseLayer);
    EXPECT_EQ(stack.sample(pixel(2.5, 1.5)).height, 7);
    EXPECT_EQ(stack.layers()[0].valid_samples, 15u);
}

// Values 10 x + y with one hole at (1, 1).
TEST(SourceUnit, BilinearLeavesHolesOut) {
    const Folder folder;
    RasterSpec s{4, 4};
    const std::string path = write_raster(folder.file("h.tif"), s, [](double u, double v) {
        const double x = std::floor(u), y = std::floor(v);
        return x == 1 && y == 1 ? kNaN : 10 * x + y;
    });
    for (const Resampling r : {Resampling::bilinear, Resampling::cubic}) {  // cubic falls back near holes
        const SourceStack stack = stack_of(path, r);
        // Between (0,0), (1,0), (0,1) and the hole, nearest to (0,0): weights 9/16, 3/16, 3/16.
        const auto value = stack.sample(pixel(0.75, 0.75));
        EXPECT_EQ(value.layer, 0);
        EXPECT_NEAR(value.height, (9 * 0 + 3 * 10 + 3 * 1) / 15.0, 1e-12);
        EXPECT_EQ(stack.sample(pixel(1.25, 1.25)).layer, kBaseLayer);  // nearest is the hole
        EXPECT_EQ(stack.sample(pixel(1.0001, 1.0001)).layer, kBaseLayer);
        EXPECT_EQ(stack.sample(pixel(0.9999, 1.0001)).layer, 0);
        EXPECT_EQ(stack.sample(pixel(2, 2)).layer, 0);
        // On a sample beside the hole the hole carries no weight.
        EXPECT_NEAR(stack.sample(pixel(0.5, 1.5)).height, 1, 1e-9);
    }
}

TEST(SourceUnit, BorderSamplesReachHalfAPixelOutwards) {
    const Folder folder;
    RasterSpec s{4, 4};
    const std::string path = write_raster(
        folder.file("b.tif"), s, [](double u, double v) { return 10 * std::floor(u) + std::floor(v); });
    for (const Resampling r : {Resampling::nearest, Resampling::bilinear, Resampling::cubic}) {
        const SourceStack stack = stack_of(path, r);
        const double overshoot = r == Resampling::cubic ? 11.0 / 16 : 0;  // of samples 0, 0, 10 and 0, 0, 1
        EXPECT_NEAR(stack.sample(pixel(0, 0.5)).height, 0, overshoot + 1e-9);
        EXPECT_NEAR(stack.sample(pixel(0.001, 0.001)).height, 0, overshoot + 0.02);
        EXPECT_NEAR(stack.sample(pixel(4, 3.5)).height, 33, overshoot + 1e-9);
        EXPECT_NEAR(stack.sample(pixel(3.999, 3.999)).height, 33, overshoot + 0.02);
        for (const auto& [u, v] : {std::pair{-1e-4, 1.0}, {4.0001, 1.0}, {1.0, -1e-4}, {1.0, 4.0001}})
            EXPECT_EQ(stack.sample(pixel(u, v)).layer, kBaseLayer) << u << ' ' << v;
    }
}

TEST(SourceUnit, FirstFileAndFirstLayerWin) {
    const Folder folder;
    const auto file = [&](const char* name, double height, double shift) {
        RasterSpec s{8, 8};
        s.transform[0] = shift;
        return write_raster(folder.file(name), s, [=](double, double) { return height; });
    };
    LayerOptions two;
    two.feather = 0;
    two.files = {file("a.tif", 1, 0), file("b.tif", 2, 4.3)};  // not on one grid
    LayerOptions one;
    one.feather = 0;
    one.files = {file("c.tif", 3, 4)};
    const SourceStack ab_c = stack_of({two, one}), c_ab = stack_of({one, two});
    EXPECT_EQ(ab_c.sample(pixel(2, 2)).height, 1);
    EXPECT_EQ(ab_c.sample(pixel(6, 2)).height, 1);
    EXPECT_EQ(ab_c.sample(pixel(9, 2)).height, 2);
    EXPECT_EQ(ab_c.sample(pixel(8.2, 2)).layer, 0);
    EXPECT_EQ(c_ab.sample(pixel(6, 2)).height, 3);
    EXPECT_EQ(c_ab.sample(pixel(2, 2)).height, 1);
    EXPECT_EQ(c_ab.sample(pixel(2, 2)).layer, 1);
}

TEST(SourceUnit, BoundsPlaceAPlainImage) {
    const Folder folder;
    RasterSpec s{36, 18};
    s.epsg = 0;
    s.georeferenced = false;
    s.type = GDT_UInt16;
    const std::string path = write_raster(
        folder.file("plain.tif"), s, [](double u, double v) { return 1000 * std::floor(u) + std::floor(v); });
    LayerOptions options = layer_of(path, Resampling::nearest);
    EXPECT_EQ(refusal({options}, "plain.tif"), ErrorCode::usage);
    options.bounds = {{-180, -90, 180, 90}};
    EXPECT_EQ(stack_of({options}).sample(at(45, 5)).height, 18004);
    options.bounds = {{170, -90, -170, 90}};  // crosses 180
    EXPECT_EQ(stack_of({options}).sample(at(45, -179.9)).height, 18004);
    EXPECT_EQ(stack_of({options}).sample(at(45, 5)).layer, kBaseLayer);
    options.bounds = {{0, 10, 20, 5}};
    EXPECT_EQ(refusal({options}, "plain.tif"), ErrorCode::usage);
    RasterSpec georeferenced{4, 4};
    LayerOptions other =
        layer_of(write_raster(folder.file("geo.tif"), georeferenced, [](double, double) { return 0; }));
    other.bounds = {{0, 0, 1, 1}};
    EXPECT_EQ(refusal({other}, "geo.tif"), ErrorCode::usage);
}

TEST(SourceUnit, MissingCrsIsLatitudeLongitudeOnlyIfItCanBe) {
    const Folder folder;
    RasterSpec s{4, 4};
    s.epsg = 0;
    const SourceStack stack =
        stack_of(write_raster(folder.file("a.tif"), s, [](double, double) { return 5; }));
    EXPECT_EQ(stack.sample(pixel(1, 1)).height, 5);
    ASSERT_EQ(stack.warnings().size(), 1u);
    EXPECT_NE(stack.warnings()[0].find("a.tif"), std::string::npos);
    s.transform = {400000, 30, 0, 5200000, 0, -30};
    EXPECT_EQ(
        refusal({layer_of(write_raster(folder.file("b.tif"), s, [](double, double) { return 5; }))}, "b.tif"),
        ErrorCode::usage);
}

TEST(SourceUnit, AnotherBodyIsRefused) {
    const Folder folder;
    RasterSpec s{4, 4};
    const LayerOptions earth =
        layer_of(write_raster(folder.file("e.tif"), s, [](double, double) { return 5; }));
    EXPECT_EQ(refusal({earth}, "e.tif", Ellipsoid::mars()), ErrorCode::usage);
    s.wkt = "+proj=longlat +R=1737400 +no_defs";
    const LayerOptions moon =
        layer_of(write_raster(folder.file("m.tif"), s, [](double, double) { return 5; }));
    EXPECT_EQ(refusal({earth, moon}, "m.tif"), ErrorCode::usage);
    EXPECT_EQ(refusal({moon}, "m.tif", Ellipsoid::moon()), std::nullopt);
}

// NAD27 goes to WGS 84 within metres only with a grid that few installations of PROJ have.
TEST(SourceUnit, AMissingTransformationGridIsSaid) {
    const Folder folder;
    RasterSpec s{16, 16};
    s.epsg = 4267;
    s.transform = {-110, 0.1, 0, 40, 0, -0.1};
    LayerOptions layer;
    layer.files = {write_raster(folder.file("nad27.tif"), s, [](double, double) { return 7.0; })};
    const SourceStack stack = stack_of({layer});
    ASSERT_FALSE(stack.layers()[0].files[0].transformation.empty());
    if (stack.warnings().empty())
        GTEST_SKIP() << "PROJ has the grid: " << stack.layers()[0].files[0].transformation;
    ASSERT_EQ(stack.warnings().size(), 1u);
    for (const char* part : {"nad27.tif", "the most accurate transformation to WGS 84", "accuracy", "needs ",
                             "which PROJ does not have; using "})
        EXPECT_NE(stack.warnings()[0].find(part), std::string::npos) << part << ": " << stack.warnings()[0];
}

TEST(SourceUnit, InformationOfALayer) {
    const Folder folder;
    RasterSpec s{20, 10};
    s.transform = {175, 0.5, 0, 45, 0, -0.5};
    const std::string a = write_raster(folder.file("a.tif"), s, [](double u, double) { return u; });
    const std::string b = write_raster(folder.file("b.tif"), s, [](double u, double) { return u; });
    const std::string c = write_raster(folder.file("c.tif"), s, [](double u, double) { return u + 1; });
    const SourceStack stack = stack_of({layer_of(a), layer_of(b), layer_of(c)});
    const LayerInfo& info = stack.layers()[0];
    EXPECT_EQ(info.name, "a.tif");
    EXPECT_EQ(info.files[0].path, a);
    EXPECT_EQ(info.files[0].driver, "GTiff");
    EXPECT_EQ(info.files[0].width, 20);
    EXPECT_EQ(info.files[0].height, 10);
    EXPECT_EQ(info.files[0].bytes, std::filesystem::file_size(a));
    EXPECT_NE(info.files[0].crs.find("WGS 84"), std::string::npos);
    EXPECT_NEAR(info.bounds.west, 175, 1e-9);
    EXPECT_NEAR(info.bounds.east, -175, 1e-9);
    EXPECT_NEAR(info.bounds.south, 40, 1e-9);
    EXPECT_NEAR(info.bounds.north, 45, 1e-9);
    EXPECT_EQ(info.samples, 200u);
    EXPECT_EQ(info.valid_share(), 1);
    EXPECT_EQ(info.files[0].hash, stack.layers()[1].files[0].hash);
    EXPECT_NE(info.files[0].hash, stack.layers()[2].files[0].hash);
}

TEST(SourceUnit, ResamplingNames) {
    for (const Resampling r : {Resampling::nearest, Resampling::bilinear, Resampling::cubic})
        EXPECT_EQ(parse_resampling(to_string(r)), r);
    EXPECT_THROW(parse_resampling("lanczos"), Error);
}

}  // namespace
}  // namespace carat::test
