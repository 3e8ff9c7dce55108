// Little GeoTIFFs in degrees.
#pragma once

#include <gdal_priv.h>

#include <array>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <vector>

namespace carat::test {

struct Raster {
    int width = 0, height = 0;
    std::array<double, 4> bounds{};                    // west, south, east, north
    std::function<double(double lat, double lon)> at;  // metres at the centre of a pixel
};

inline void write_raster(const std::filesystem::path& file, const Raster& r) {
    GDALAllRegister();
    const double dx = (r.bounds[2] - r.bounds[0]) / r.width, dy = (r.bounds[3] - r.bounds[1]) / r.height;
    std::vector<float> values;
    for (int y = 0; y < r.height; ++y)
        for (int x = 0; x < r.width; ++x)
            values.push_back(
                static_cast<float>(r.at(r.bounds[3] - (y + 0.5) * dy, r.bounds[0] + (x + 0.5) * dx)));
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    const GDALDatasetUniquePtr out(driver->Create(file.c_str(), r.width, r.height, 1, GDT_Float32, nullptr));
    if (!out) throw std::runtime_error("cannot create " + file.string());
    std::array<double, 6> transform{r.bounds[0], dx, 0, r.bounds[3], 0, -dy};
    OGRSpatialReference wgs84;
    wgs84.SetFromUserInput("EPSG:4326");
    if (out->SetGeoTransform(transform.data()) != CE_None || out->SetSpatialRef(&wgs84) != CE_None ||
        out->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, r.width, r.height, values.data(), r.width, r.height,
                                        GDT_Float32, 0, 0) != CE_None)
        throw std::runtime_error("cannot write " + file.string());
}

// A whole planet of gentle hills, 1024 x 512.
inline Raster hills() {
    return {1024, 512, {-180, -90, 180, 90}, [](double lat, double lon) {
                constexpr double kDegree = 3.14159265358979323846 / 180;
                return 1000 * std::cos(3 * lon * kDegree) * std::cos(lat * kDegree) + 20 * lat;
            }};
}
// A whole planet of one height.
inline Raster flat(double height) {
    return {1024, 512, {-180, -90, 180, 90}, [height](double, double) { return height; }};
}

}  // namespace carat::test
