// finest_spacing: what drives the depth of a build.
#include <gtest/gtest.h>

#include "carat/globe/bounds.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/locate.hpp"
#include "raster_maker.hpp"

namespace carat::test {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegree = 111319.49;  // metres of longitude on the equator of WGS 84
constexpr double kLatitudeDegree = 110574.3;

DiamondId diamond_around(double lat, double lon, int level) {
    return locate(lattice_position(at(lat, lon)), level).half.diamond;
}

double constant(double, double) { return 1; }

TEST(SourceSpacing, GeometricMeanAtTheEquatorHalfTheCoarserAxisAtThePole) {
    const Folder folder;
    RasterSpec s{3600, 1800};
    s.transform = {-180, 0.1, 0, 90, 0, -0.1};
    s.type = GDT_Byte;
    const SourceStack stack = stack_of(write_raster(folder.file("w.tif"), s, constant));
    EXPECT_NEAR(stack.finest_spacing(diamond_around(0, 20, 14)), 0.1 * std::sqrt(kDegree * kLatitudeDegree),
                30);
    EXPECT_NEAR(stack.finest_spacing(diamond_around(60, 20, 14)), 0.1 * std::sqrt(kDegree / 2 * 111412),
                0.02 * 0.1 * kDegree);
    const double polar = 0.1 * 111694 / 2;
    for (const double lat : {90.0, -90.0})
        EXPECT_NEAR(stack.finest_spacing(diamond_around(lat, 0, 14)), polar, 5);
    for (int f = 0; f < kFaces; ++f) {
        const double finest = f < 4 ? 0.1 * std::sqrt(kDegree * 111100) * std::sqrt(0.707) : polar;
        EXPECT_LE(stack.finest_spacing(root_diamond(f)), finest) << f;
        EXPECT_GE(stack.finest_spacing(root_diamond(f)), polar - 5) << f;
    }
}

TEST(SourceSpacing, OnlyWhereSamplesAre) {
    const Folder folder;
    RasterSpec s{640, 640};
    s.transform = {10, 0.01, 0, 50, 0, -0.01};
    // Valid in the western half only.
    const SourceStack stack =
        stack_of(write_raster(folder.file("v.tif"), s, [](double u, double) { return u < 320 ? 1 : kNaN; }));
    for (int level = 14; level < 24; ++level) {
        EXPECT_LT(stack.finest_spacing(diamond_around(47, 11, level)), 1000) << level;
        EXPECT_EQ(stack.finest_spacing(diamond_around(47, 30, level)), kInf) << level;
        EXPECT_EQ(stack.finest_spacing(diamond_around(-47, 11, level)), kInf) << level;
    }
    EXPECT_EQ(stack.finest_spacing(diamond_around(47, 15, 20)), kInf);  // inside the raster, among holes
    for (int face = 0; face < kFaces; ++face)
        EXPECT_EQ(stack.finest_spacing(root_diamond(face)) < 1000, face == 0 || face == 4) << face;
}

// Every diamond that contains a valid sample must see it, at every level and in every CRS.
TEST(SourceSpacing, NoSampleIsMissed) {
    const Folder folder;
    const auto check = [&](RasterSpec s, const char* name) {
        s.type = GDT_Float32;
        s.width = s.height = 100;
        std::mt19937_64 random(3);
        std::vector<std::array<double, 2>> samples;
        const SourceStack stack = stack_of(write_raster(folder.file(name), s, [&](double u, double v) {
            if (random() % 500 != 0) return kNaN;
            samples.push_back({u, v});
            return 1.0;
        }));
        const OGRSpatialReference raster = srs_of(s);
        OGRSpatialReference wgs84;
        wgs84.importFromEPSG(4326);
        wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        const std::unique_ptr<OGRCoordinateTransformation> t(
            OGRCreateCoordinateTransformation(&raster, &wgs84));
        ASSERT_FALSE(samples.empty());
        for (const auto& [u, v] : samples) {
            auto [x, y] = to_crs(s, u, v);
            ASSERT_TRUE(t->Transform(1, &x, &y));
            for (int level = 0; level < 30; ++level)
                ASSERT_LT(stack.finest_spacing(diamond_around(y, x, level)), 1e6)
                    << name << ' ' << x << ' ' << y << ' ' << level;
        }
    };
    RasterSpec s;
    s.transform = {10, 0.01, 0, 50, 0, -0.01};
    check(s, "degrees.tif");
    s.transform = {179.5, 0.01, 0, 50, 0, -0.01};
    check(s, "antimeridian.tif");
    s.transform = {-180, 3.6, 0, 90, 0, -1.8};
    check(s, "world.tif");
    s.transform = {20, 0.01, 0, 90, 0, -0.01};
    check(s, "north.tif");
    s.transform = {10, 0.08, 0.06, 50, 0.06, -0.08};
    check(s, "rotated.tif");
    s.transform = {400000, 30, 0, 5200000, 0, -30};
    s.epsg = 32633;
    check(s, "utm.tif");
    s.transform = {-1e6, 20000, 0, 1e6, 0, -20000};
    s.epsg = 3031;
    check(s, "polar.tif");
}

TEST(SourceSpacing, TheWinningLayerCounts) {
    const Folder folder;
    RasterSpec coarse{100, 100};
    coarse.transform = {10, 0.1, 0, 50, 0, -0.1};
    RasterSpec fine{400, 400};
    fine.transform = {13, 0.01, 0, 47, 0, -0.01};
    const LayerOptions c = layer_of(write_raster(folder.file("c.tif"), coarse, constant));
    const LayerOptions f = layer_of(write_raster(folder.file("f.tif"), fine, constant));
    const DiamondId inside = diamond_around(45, 15, 16), beside = diamond_around(49, 11, 16);
    const SourceStack fine_first = stack_of({f, c}), coarse_first = stack_of({c, f});
    EXPECT_LT(fine_first.finest_spacing(inside), 1200);
    EXPECT_GT(fine_first.finest_spacing(beside), 8000);
    EXPECT_GT(coarse_first.finest_spacing(inside), 8000);  // the finer layer is hidden
    EXPECT_GT(coarse_first.finest_spacing(root_diamond(0)), 8000);
}

TEST(SourceSpacing, AllNoDataIsNothing) {
    const Folder folder;
    RasterSpec s{64, 64};
    s.nodata = 0;
    const SourceStack stack =
        stack_of(write_raster(folder.file("n.tif"), s, [](double, double) { return 0; }));
    for (int face = 0; face < kFaces; ++face) EXPECT_EQ(stack.finest_spacing(root_diamond(face)), kInf);
    EXPECT_EQ(stack.sample(at(-3, 3)).layer, kBaseLayer);
    EXPECT_EQ(stack.layers()[0].valid_share(), 0);
}

}  // namespace
}  // namespace carat::test
