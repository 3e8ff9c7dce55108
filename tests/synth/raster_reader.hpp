// Rasters read back through GDAL alone, with the geodetic normal of every pixel centre by way of PROJ and
// plain trigonometry: nothing here is shared with the code that wrote them.
#pragma once

#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace carat::synth::test {

/// A directory of this test's own, removed at the end.
class Directory {
  public:
    explicit Directory(const std::string& name)
        : path_(std::filesystem::temp_directory_path() /
                ("carat_" + name + "_" + std::to_string(::getpid()))) {
        std::filesystem::remove_all(path_);
    }
    ~Directory() { std::filesystem::remove_all(path_); }
    Directory(const Directory&) = delete;
    Directory& operator=(const Directory&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

struct Raster {
    int width = 0, height = 0;
    std::array<double, 6> transform{};
    GDALDataType type = GDT_Unknown;
    std::optional<double> nodata;
    std::string crs_wkt;
    std::vector<double> samples;

    double at(int column, int row) const {
        return samples[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                       static_cast<std::size_t>(column)];
    }
};

/// Nothing when GDAL cannot open the file or read every sample.
inline std::optional<Raster> read_raster(const std::filesystem::path& path) {
    GDALAllRegister();
    CPLPushErrorHandler(CPLQuietErrorHandler);
    std::optional<Raster> result;
    const std::unique_ptr<GDALDataset> d(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
    if (d) {
        Raster r;
        r.width = d->GetRasterXSize();
        r.height = d->GetRasterYSize();
        d->GetGeoTransform(r.transform.data());
        GDALRasterBand* band = d->GetRasterBand(1);
        r.type = band->GetRasterDataType();
        int has = 0;
        const double nodata = band->GetNoDataValue(&has);
        if (has) r.nodata = nodata;
        char* wkt = nullptr;
        if (d->GetSpatialRef()) d->GetSpatialRef()->exportToWkt(&wkt);
        r.crs_wkt = wkt ? wkt : "";
        CPLFree(wkt);
        r.samples.resize(static_cast<std::size_t>(r.width) * static_cast<std::size_t>(r.height));
        if (band->RasterIO(GF_Read, 0, 0, r.width, r.height, r.samples.data(), r.width, r.height, GDT_Float64,
                           0, 0, nullptr) == CE_None)
            result = std::move(r);
    }
    CPLPopErrorHandler();
    return result;
}

/// From pixel centres to geodetic normals.
class Locator {
  public:
    explicit Locator(const Raster& raster) : transform_(raster.transform) {
        crs_.importFromWkt(raster.crs_wkt.c_str());
        crs_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        geographic_ = crs_.IsGeographic();
        if (geographic_) return;
        const std::unique_ptr<OGRSpatialReference> degrees(crs_.CloneGeogCS());
        degrees->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        to_degrees_.reset(OGRCreateCoordinateTransformation(&crs_, degrees.get()));
    }
    /// Longitude and latitude in degrees.
    std::array<double, 2> degrees(double column, double row) const {
        const auto& t = transform_;
        double x = t[0] + (column + 0.5) * t[1] + (row + 0.5) * t[2];
        double y = t[3] + (column + 0.5) * t[4] + (row + 0.5) * t[5];
        if (!geographic_) to_degrees_->Transform(1, &x, &y);
        return {x, y};
    }
    std::array<double, 3> normal(double column, double row) const {
        const auto [longitude, latitude] = degrees(column, row);
        const double a = longitude * std::numbers::pi / 180, b = latitude * std::numbers::pi / 180;
        return {std::cos(b) * std::cos(a), std::cos(b) * std::sin(a), std::sin(b)};
    }

  private:
    std::array<double, 6> transform_;
    OGRSpatialReference crs_;
    bool geographic_ = false;
    std::unique_ptr<OGRCoordinateTransformation> to_degrees_;
};

}  // namespace carat::synth::test
