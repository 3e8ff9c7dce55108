// Small rasters for tests, written with GDAL into a folder that goes away with the test.
#pragma once

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "carat/preprocess/source.hpp"

namespace carat::test {

class Folder {
  public:
    Folder() {
        const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
        path_ = std::filesystem::temp_directory_path() /
                ("carat-" + std::to_string(getpid()) + "-" + test->test_suite_name() + "-" + test->name());
        std::filesystem::create_directories(path_);
        GDALAllRegister();
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::string file(const std::string& name) const { return (path_ / name).string(); }

  private:
    std::filesystem::path path_;
};

using Value = std::function<double(double x, double y)>;  // of pixel coordinates of the sample's centre

struct RasterSpec {
    int width = 16, height = 16;
    std::array<double, 6> transform{0, 1, 0, 0, 0, -1};
    int epsg = 4326;       // 0: none
    std::string wkt = {};  // instead of epsg
    GDALDataType type = GDT_Float64;
    std::optional<double> nodata = {};
    std::vector<std::string> options = {};
    bool georeferenced = true;
    std::optional<double> scale = {}, offset = {};
    std::string unit = {};
};

// CRS coordinates of pixel coordinates.
inline std::array<double, 2> to_crs(const RasterSpec& s, double u, double v) {
    const auto& g = s.transform;
    return {g[0] + u * g[1] + v * g[2], g[3] + u * g[4] + v * g[5]};
}

inline OGRSpatialReference srs_of(const RasterSpec& s) {
    OGRSpatialReference srs;
    if (!s.wkt.empty())
        srs.SetFromUserInput(s.wkt.c_str());
    else if (s.epsg != 0)
        srs.importFromEPSG(s.epsg);
    srs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return srs;
}

inline std::string write_raster(const std::string& path, const RasterSpec& s, const Value& value,
                                const char* driver = "GTiff") {
    char** options = nullptr;
    for (const std::string& o : s.options) options = CSLAddString(options, o.c_str());
    GDALDataset* d = GetGDALDriverManager()->GetDriverByName(driver)->Create(path.c_str(), s.width, s.height,
                                                                             1, s.type, options);
    CSLDestroy(options);
    EXPECT_NE(d, nullptr) << path;
    std::array<double, 6> transform = s.transform;
    if (s.georeferenced) d->SetGeoTransform(transform.data());
    if (s.epsg != 0 || !s.wkt.empty()) {
        const OGRSpatialReference srs = srs_of(s);
        d->SetSpatialRef(&srs);
    }
    GDALRasterBand* band = d->GetRasterBand(1);
    if (s.nodata) band->SetNoDataValue(*s.nodata);
    if (s.scale) band->SetScale(*s.scale);
    if (s.offset) band->SetOffset(*s.offset);
    if (!s.unit.empty()) band->SetUnitType(s.unit.c_str());
    std::vector<double> row(static_cast<std::size_t>(s.width));
    for (int y = 0; y < s.height; ++y) {
        for (int x = 0; x < s.width; ++x) row[static_cast<std::size_t>(x)] = value(x + 0.5, y + 0.5);
        EXPECT_EQ(
            band->RasterIO(GF_Write, 0, y, s.width, 1, row.data(), s.width, 1, GDT_Float64, 0, 0, nullptr),
            CE_None);
    }
    GDALClose(d);
    return path;
}

inline LayerOptions layer_of(const std::string& path, Resampling resampling = Resampling::bilinear) {
    LayerOptions options;
    options.files = {path};
    options.resampling = resampling;
    options.feather = 0;
    return options;
}

inline constexpr std::size_t kCache = std::size_t{64} << 20;
inline constexpr double kBase = -12345;

inline SourceStack stack_of(const std::vector<LayerOptions>& layers,
                            const Ellipsoid& body = Ellipsoid::earth()) {
    return SourceStack(layers, body, kBase, kCache);
}
inline SourceStack stack_of(const std::string& path, Resampling resampling = Resampling::bilinear) {
    return stack_of({layer_of(path, resampling)});
}

inline Vec3 at(double lat, double lon) { return direction(Geodetic{lat, lon}); }

// The error code with which a stack refuses its layers; the message must name `file`.
inline std::optional<ErrorCode> refusal(const std::vector<LayerOptions>& layers, const std::string& file,
                                        const Ellipsoid& body = Ellipsoid::earth()) {
    try {
        stack_of(layers, body);
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find(file), std::string::npos) << error.what();
        return error.code();
    }
    return std::nullopt;
}

// GDAL's own resampling at pixel coordinates: a window of one pixel, read into one pixel.
inline double gdal_value(GDALDataset& d, double u, double v, GDALRIOResampleAlg algorithm) {
    GDALRasterIOExtraArg extra;
    INIT_RASTERIO_EXTRA_ARG(extra);
    extra.eResampleAlg = algorithm;
    extra.bFloatingPointWindowValidity = TRUE;
    extra.dfXOff = u - 0.5;
    extra.dfYOff = v - 0.5;
    extra.dfXSize = extra.dfYSize = 1;
    double value = std::numeric_limits<double>::quiet_NaN();
    const int x = std::clamp(static_cast<int>(std::floor(u - 0.5)), 0, d.GetRasterXSize() - 2);
    const int y = std::clamp(static_cast<int>(std::floor(v - 0.5)), 0, d.GetRasterYSize() - 2);
    EXPECT_EQ(d.GetRasterBand(1)->RasterIO(GF_Read, x, y, 2, 2, &value, 1, 1, GDT_Float64, 0, 0, &extra),
              CE_None);
    return value;
}

}  // namespace carat::test
