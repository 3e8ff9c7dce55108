#include "carat/bench/raster.hpp"

#include <gdal_priv.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "carat/globe/error.hpp"

namespace carat::bench {
namespace {

using Doubles = std::vector<double>;

struct CloseDataset {
    void operator()(GDALDataset* d) const { GDALClose(d); }
};

// Fills the holes (NaN) of one row from its own samples; false if it has none.
bool fill_row(double* row, int width, std::size_t& filled) {
    const double* first = std::find_if(row, row + width, [](double x) { return std::isfinite(x); });
    if (first == row + width) return false;
    double last = *first;
    for (int x = 0; x < width; ++x) {
        if (std::isfinite(row[x]))
            last = row[x];
        else {
            row[x] = last;
            ++filled;
        }
    }
    return true;
}

void fill_holes(Doubles& samples, int width, int height, const std::string& file, std::size_t& filled) {
    std::vector<bool> has(static_cast<std::size_t>(height));
    const auto row = [&](int y) { return samples.data() + static_cast<std::ptrdiff_t>(y) * width; };
    int first = -1;
    for (int y = 0; y < height; ++y) {
        has[static_cast<std::size_t>(y)] = fill_row(row(y), width, filled);
        if (has[static_cast<std::size_t>(y)] && first < 0) first = y;
    }
    if (first < 0) throw Error(ErrorCode::usage, file + ": no valid sample in the part that was asked for");
    for (int y = 0, source = first; y < height; ++y) {
        if (has[static_cast<std::size_t>(y)])
            source = y;
        else {
            std::copy(row(source), row(source) + width, row(y));
            filled += static_cast<std::size_t>(width);
        }
    }
}

Crop checked(const std::optional<Crop>& crop, int width, int height, const std::string& file) {
    const Crop c = crop.value_or(Crop{0, 0, width, height});
    if (c.x < 0 || c.y < 0 || c.width < 1 || c.height < 1 || c.x > width - c.width || c.y > height - c.height)
        throw Error(ErrorCode::usage, file + ": the crop is not inside the raster of " +
                                          std::to_string(width) + " x " + std::to_string(height));
    return c;
}

Raster narrowed(const Doubles& samples, const Crop& c, bool integer_type) {
    Raster out;
    out.width = c.width;
    out.height = c.height;
    out.integer = integer_type && std::all_of(samples.begin(), samples.end(), [](double x) {
                      return x >= std::numeric_limits<std::int16_t>::min() &&
                             x <= std::numeric_limits<std::int16_t>::max() && x == std::floor(x);
                  });
    if (out.integer)
        for (const double x : samples) out.whole.push_back(static_cast<std::int16_t>(x));
    else
        for (const double x : samples) out.real.push_back(static_cast<float>(x));
    return out;
}

}  // namespace

Raster Raster::like(int w, int h) const {
    Raster out;
    out.width = w;
    out.height = h;
    out.integer = integer;
    if (integer)
        out.whole.resize(out.size());
    else
        out.real.resize(out.size());
    return out;
}

Raster read_raster(const std::string& file, const std::optional<Crop>& crop, std::size_t& filled,
                   int band_number) {
    GDALAllRegister();
    CPLPushErrorHandler(CPLQuietErrorHandler);
    const std::unique_ptr<GDALDataset, CloseDataset> dataset(static_cast<GDALDataset*>(GDALOpenEx(
        file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, nullptr, nullptr, nullptr)));
    CPLPopErrorHandler();
    if (!dataset) throw Error(ErrorCode::io, file + ": " + CPLGetLastErrorMsg());
    if (dataset->GetRasterCount() < band_number)
        throw Error(ErrorCode::unsupported, file + ": has no band " + std::to_string(band_number));
    GDALRasterBand& band = *dataset->GetRasterBand(band_number);
    const Crop c = checked(crop, dataset->GetRasterXSize(), dataset->GetRasterYSize(), file);
    Doubles samples(static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height));
    if (band.RasterIO(GF_Read, c.x, c.y, c.width, c.height, samples.data(), c.width, c.height, GDT_Float64, 0,
                      0) != CE_None)
        throw Error(ErrorCode::io, file + ": " + CPLGetLastErrorMsg());
    int has_nodata = 0;
    const double nodata = band.GetNoDataValue(&has_nodata);
    for (double& x : samples)
        if (!std::isfinite(x) || (has_nodata != 0 && x == nodata))
            x = std::numeric_limits<double>::quiet_NaN();
    filled = 0;
    fill_holes(samples, c.width, c.height, file, filled);
    return narrowed(samples, c, GDALDataTypeIsInteger(band.GetRasterDataType()) != 0);
}

namespace {

// visit(tile number, x, y, width, height)
template <class Visit>
void for_tiles(int width, int height, int size, Visit visit) {
    const int step_x = size > 0 ? size : width, step_y = size > 0 ? size : height;
    std::size_t k = 0;
    for (int y = 0; y < height; y += step_y)
        for (int x = 0; x < width; x += step_x)
            visit(k++, x, y, std::min(step_x, width - x), std::min(step_y, height - y));
}

template <class Sample>
void copy_block(const std::vector<Sample>& in, int in_width, int in_x, int in_y, std::vector<Sample>& out,
                int out_width, int out_x, int out_y, int w, int h) {
    for (int r = 0; r < h; ++r)
        std::copy_n(in.begin() + (static_cast<std::ptrdiff_t>(in_y + r) * in_width + in_x), w,
                    out.begin() + (static_cast<std::ptrdiff_t>(out_y + r) * out_width + out_x));
}

}  // namespace

std::vector<Raster> cut_tiles(const Raster& raster, int size) {
    std::vector<Raster> out;
    for_tiles(raster.width, raster.height, size, [&](std::size_t, int x, int y, int w, int h) {
        Raster& t = out.emplace_back(raster.like(w, h));
        if (raster.integer)
            copy_block(raster.whole, raster.width, x, y, t.whole, w, 0, 0, w, h);
        else
            copy_block(raster.real, raster.width, x, y, t.real, w, 0, 0, w, h);
    });
    return out;
}

void join_tiles(const std::vector<Raster>& tiles, int size, Raster& out) {
    for_tiles(out.width, out.height, size, [&](std::size_t k, int x, int y, int w, int h) {
        if (out.integer)
            copy_block(tiles[k].whole, w, 0, 0, out.whole, out.width, x, y, w, h);
        else
            copy_block(tiles[k].real, w, 0, 0, out.real, out.width, x, y, w, h);
    });
}

Errors compare(const Raster& a, const Raster& b) {
    Errors e;
    double squares = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        const double d = std::abs(a.at(k) - b.at(k));
        e.max = std::max(e.max, d);
        squares += d * d;
    }
    e.rms = a.size() > 0 ? std::sqrt(squares / static_cast<double>(a.size())) : 0;
    return e;
}

}  // namespace carat::bench
