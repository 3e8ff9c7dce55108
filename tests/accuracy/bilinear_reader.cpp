#include "bilinear_reader.hpp"

#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace carat::test {

BilinearReader::BilinearReader(const std::string& path) {
    GDALAllRegister();
    auto* const data = static_cast<GDALDataset*>(GDALOpen(path.c_str(), GA_ReadOnly));
    if (data == nullptr) throw std::runtime_error("cannot open " + path);
    std::array<double, 6> transform{};
    data->GetGeoTransform(transform.data());
    west_ = transform[0];
    step_x_ = transform[1];
    north_ = transform[3];
    step_y_ = transform[5];
    width_ = data->GetRasterXSize();
    height_ = data->GetRasterYSize();
    global_ = std::abs(step_x_ * width_ - 360) < 1e-6;
    pixels_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    const CPLErr failed = data->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, width_, height_, pixels_.data(),
                                                           width_, height_, GDT_Float32, 0, 0);
    GDALClose(data);
    if (failed != CE_None) throw std::runtime_error("cannot read " + path);
}

double BilinearReader::sample(int column, int row) const {
    column = global_ ? ((column % width_) + width_) % width_ : std::clamp(column, 0, width_ - 1);
    row = std::clamp(row, 0, height_ - 1);
    return static_cast<double>(pixels_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                                       static_cast<std::size_t>(column)]);
}

double BilinearReader::height(double latitude, double longitude) const {
    const double x = (longitude - west_) / step_x_ - 0.5, y = (latitude - north_) / step_y_ - 0.5;
    const int c = static_cast<int>(std::floor(x)), r = static_cast<int>(std::floor(y));
    const double fx = x - c, fy = y - r;
    return (1 - fy) * ((1 - fx) * sample(c, r) + fx * sample(c + 1, r)) +
           fy * ((1 - fx) * sample(c, r + 1) + fx * sample(c + 1, r + 1));
}

double BilinearReader::relief(double latitude, double longitude, int radius) const {
    const int c = static_cast<int>(std::floor((longitude - west_) / step_x_ - 0.5));
    const int r = static_cast<int>(std::floor((latitude - north_) / step_y_ - 0.5));
    // As far eastwards as northwards on the ground.
    const double columns = radius / std::max(std::cos(latitude * 3.14159265358979 / 180), 1e-9);
    const int across = static_cast<int>(std::min(std::ceil(columns), width_ / 2.0));
    double low = sample(c, r), high = low;
    for (int i = r - radius; i <= r + 1 + radius; ++i)
        for (int j = c - across; j <= c + 1 + across; ++j) {
            low = std::min(low, sample(j, i));
            high = std::max(high, sample(j, i));
        }
    return high - low;
}

}  // namespace carat::test
