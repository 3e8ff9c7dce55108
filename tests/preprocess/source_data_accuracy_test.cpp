// Real files: bounds and spacing as documented, heights as GDAL reads them.
#include <gtest/gtest.h>

#include "carat/globe/error.hpp"
#include "raster_maker.hpp"
#include "support/test_data.hpp"

namespace carat::test {
namespace {

struct Expected {
    const char* file;
    GeoBounds bounds;
    double spacing, tolerance;  // metres
    double valid_from, valid_to;
};

void expect_layer(const Expected& e, const Ellipsoid& body = Ellipsoid::earth()) {
    const SourceStack stack = stack_of({layer_of(data_file(e.file))}, body);
    const LayerInfo& info = stack.layers()[0];
    EXPECT_NEAR(info.bounds.west, e.bounds.west, 2e-4);
    EXPECT_NEAR(info.bounds.east, e.bounds.east, 2e-4);
    EXPECT_NEAR(info.bounds.south, e.bounds.south, 2e-4);
    EXPECT_NEAR(info.bounds.north, e.bounds.north, 2e-4);
    EXPECT_NEAR(info.spacing, e.spacing, e.tolerance);
    EXPECT_GE(info.valid_share(), e.valid_from);
    EXPECT_LE(info.valid_share(), e.valid_to);
}

// 5' of the equator: 1855.3 m by 1842.9 m a minute.
TEST(SourceData, Earth) {
    CARAT_NEEDS_DATA("earth_5min.tif");
    expect_layer({"earth_5min.tif", {-180, -90, 180, 90}, 5 * std::sqrt(1855.3 * 1842.9), 5, 1, 1});
}
TEST(SourceData, California) {
    CARAT_NEEDS_DATA("california_3s.tif");
    expect_layer({"california_3s.tif",
                  {-125.0004167, 35.9995833, -113.9995833, 40.0004167},
                  std::sqrt(92.77 * std::cos(38 * 0.01745329) * 92.49),
                  0.3,
                  0.85,
                  0.95});
}
TEST(SourceData, Rainier) {
    CARAT_NEEDS_DATA("rainier_3s_voids.tif");
    expect_layer({"rainier_3s_voids.tif",
                  {-122.0004167, 45.9995833, -120.9995833, 47.0004167},
                  std::sqrt(92.77 * std::cos(46.5 * 0.01745329) * 92.63),
                  0.3,
                  0.99,
                  0.995});
}
TEST(SourceData, Athens) {
    CARAT_NEEDS_DATA("athens_dsm_1m.tif");
    expect_layer({"athens_dsm_1m.tif", {23.73744, 38.00262, 23.74201, 38.00623}, 1, 0.001, 0.99, 1});
}
TEST(SourceData, City) {
    CARAT_NEEDS_DATA("city_nl_0p5m.tif");
    expect_layer({"city_nl_0p5m.tif", {4.19780, 52.04341, 4.20492, 52.04726}, 0.5, 0.001, 0.9, 0.99});
}
TEST(SourceData, Mars) {
    CARAT_NEEDS_DATA("mars_mola_15min.tif");
    expect_layer({"mars_mola_15min.tif", {-180, -90, 180, 90}, 14800, 120, 1, 1}, Ellipsoid::mars());
}

// The 4 x 4 samples around a place as a raster of doubles in memory (GDAL rounds what it resamples to the
// file's type).
class Window {
  public:
    Window(GDALDataset& d, double u, double v) : x_(static_cast<int>(u) - 2), y_(static_cast<int>(v) - 2) {
        EXPECT_EQ(d.GetRasterBand(1)->RasterIO(GF_Read, x_, y_, 4, 4, samples_.data(), 4, 4, GDT_Float64, 0,
                                               0, nullptr),
                  CE_None);
    }
    bool whole() const {
        return std::all_of(samples_.begin(), samples_.end(),
                           [](double h) { return std::isfinite(h) && h > -9000; });
    }
    double bilinear(double u, double v) {
        GDALDataset* d =
            GetGDALDriverManager()->GetDriverByName("MEM")->Create("", 4, 4, 1, GDT_Float64, nullptr);
        EXPECT_EQ(d->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, 4, 4, samples_.data(), 4, 4, GDT_Float64, 0,
                                                0, nullptr),
                  CE_None);
        const double value = gdal_value(*d, u - x_, v - y_, GRIORA_Bilinear);
        GDALClose(d);
        return value;
    }

  private:
    int x_, y_;
    std::array<double, 16> samples_{};
};

// Independent path: GDAL's coordinate transformation and GDAL's bilinear reading.
void expect_gdals_heights(const char* file, double tolerance) {
    const SourceStack stack = stack_of(data_file(file));
    GDALAllRegister();
    GDALDataset* d = GDALDataset::Open(data_file(file).c_str());
    ASSERT_NE(d, nullptr);
    OGRSpatialReference srs = *d->GetSpatialRef(), wgs84;
    srs.StripVertical();
    wgs84.importFromEPSG(4326);
    wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    using Transformation = std::unique_ptr<OGRCoordinateTransformation>;
    const Transformation to_wgs84(OGRCreateCoordinateTransformation(&srs, &wgs84));
    const Transformation from_wgs84(OGRCreateCoordinateTransformation(&wgs84, &srs));
    std::array<double, 6> g{};
    d->GetGeoTransform(g.data());
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> u(3, d->GetRasterXSize() - 3), v(3, d->GetRasterYSize() - 3);
    int compared = 0;
    double worst = 0;
    for (int i = 0; i < 1500; ++i) {
        double x = g[0] + u(random) * g[1], y = g[3] + v(random) * g[5];
        ASSERT_TRUE(to_wgs84->Transform(1, &x, &y));
        const auto value = stack.sample(at(y, x));
        // There and back again: a datum transformation in two dimensions loses millimetres.
        ASSERT_TRUE(from_wgs84->Transform(1, &x, &y));
        const double pu = (x - g[0]) / g[1], pv = (y - g[3]) / g[5];
        Window window(*d, pu, pv);
        if (!window.whole()) continue;
        ASSERT_EQ(value.layer, 0);
        worst = std::max(worst, std::abs(value.height - window.bilinear(pu, pv)));
        ++compared;
    }
    GDALClose(d);
    EXPECT_GT(compared, 1000);
    EXPECT_LE(worst, tolerance);
    std::printf("%s: %d places, greatest difference from GDAL %.3g m\n", file, compared, worst);
}

TEST(SourceData, CaliforniaAsGdalReadsIt) {
    CARAT_NEEDS_DATA("california_3s.tif");
    expect_gdals_heights("california_3s.tif", 5e-4);  // GDAL computes in floats
}
TEST(SourceData, AthensAsGdalReadsIt) {
    CARAT_NEEDS_DATA("athens_dsm_1m.tif");
    expect_gdals_heights("athens_dsm_1m.tif", 1e-3);
}
TEST(SourceData, CityAsGdalReadsIt) {
    CARAT_NEEDS_DATA("city_nl_0p5m.tif");
    // Of two forms of the same datum transformation, 0.1 mm apart, GDAL may choose the other; walls rise 40 m
    // a pixel.
    expect_gdals_heights("city_nl_0p5m.tif", 0.02);
}

}  // namespace
}  // namespace carat::test
