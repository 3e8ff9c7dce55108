#include "raster_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "carat/globe/error.hpp"
#include "colour_raster.hpp"
#include "gdal_raster.hpp"
#include "image_raster.hpp"

namespace carat {
namespace {

// The value as GDAL writes it into samples of type T; nothing if none can equal it.
template <class T>
std::optional<T> as_sample(double value) {
    if constexpr (std::is_integral_v<T>) {
        if (!(value >= std::numeric_limits<T>::min() && value <= std::numeric_limits<T>::max()) ||
            value != std::floor(value))
            return std::nullopt;
    } else if constexpr (std::is_same_v<T, float>) {
        constexpr double kMax = std::numeric_limits<float>::max();
        if (std::isfinite(value)) return static_cast<float>(std::clamp(value, -kMax, kMax));
    }
    return static_cast<T>(value);
}

}  // namespace

RasterFile::RasterFile(RasterHeader header, const LayerOptions& options)
    : header_(std::move(header)), valid_range_(options.valid_range) {
    if (valid_range_) header_.may_have_holes = true;
    if (header_.type == SampleType::float32 || header_.type == SampleType::float64)
        header_.may_have_holes = true;
    if (options.nodata) add_nodata(*options.nodata);
}

void RasterFile::add_nodata(double value) {
    nodata_.push_back(value);
    header_.may_have_holes = true;
}

template <class T>
void RasterFile::mark_holes(const T* samples, std::size_t count, std::uint8_t* valid) const {
    if constexpr (std::is_floating_point_v<T>)
        for (std::size_t i = 0; i < count; ++i) valid[i] = std::isfinite(samples[i]) ? valid[i] : 0;
    for (const double nodata : nodata_) {
        const std::optional<T> hole = as_sample<T>(nodata);
        if (!hole) continue;
        for (std::size_t i = 0; i < count; ++i) valid[i] = samples[i] == *hole ? 0 : valid[i];
    }
    if (!valid_range_) return;
    for (std::size_t i = 0; i < count; ++i) {
        const double height = header_.offset + header_.scale * static_cast<double>(samples[i]);
        if (!(height >= (*valid_range_)[0] && height <= (*valid_range_)[1])) valid[i] = 0;
    }
}

void RasterFile::read(const PixelWindow& window, void* samples, std::uint8_t* valid) const {
    const std::size_t count =
        static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
    std::memset(valid, 1, count);
    read_samples(window, samples);
    apply_mask(window, valid);
    switch (header_.type) {
        case SampleType::int16:
            return mark_holes(static_cast<const std::int16_t*>(samples), count, valid);
        case SampleType::int32:
            return mark_holes(static_cast<const std::int32_t*>(samples), count, valid);
        case SampleType::float32:
            return mark_holes(static_cast<const float*>(samples), count, valid);
        case SampleType::float64:
            return mark_holes(static_cast<const double*>(samples), count, valid);
    }
}

std::unique_ptr<RasterFile> RasterFile::open(const std::string& path, const LayerOptions& options,
                                             HandlePool& handles, std::vector<std::string>& warnings) {
    if (options.colour_component) return open_colour_raster(path, options, handles, warnings);
    try {
        return open_gdal_raster(path, options, handles, warnings);
    } catch (const Error& error) {
        if (!options.bounds || error.code() != ErrorCode::io) throw;
        if (auto image = open_image_raster(path, options)) return image;
        throw;
    }
}

}  // namespace carat
