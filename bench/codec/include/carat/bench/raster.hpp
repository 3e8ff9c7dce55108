// Samples that all contestants of a benchmark get: a matrix of int16 or float32.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace carat::bench {

// The nearest int16: what is decoded may lie beyond the ends of the type by as much as the tolerance.
inline std::int16_t to_int16(std::int32_t x) {
    return static_cast<std::int16_t>(std::clamp<std::int32_t>(x, INT16_MIN, INT16_MAX));
}

struct Raster {
    int width = 0, height = 0;
    bool integer = false;             // which of the two holds the samples
    std::vector<std::int16_t> whole;  // row-major, width * height
    std::vector<float> real;

    std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
    std::size_t bytes() const { return size() * (integer ? sizeof(std::int16_t) : sizeof(float)); }
    double at(std::size_t k) const { return integer ? whole[k] : static_cast<double>(real[k]); }
    // Same shape and type, samples 0.
    Raster like() const { return like(width, height); }
    Raster like(int w, int h) const;
};

struct Crop {
    int x = 0, y = 0, width = 0, height = 0;  // pixels
};

// A band of a file GDAL reads, counted from 1. Integer types whose samples fit int16 stay integers, all else
// becomes float32. Missing samples (nodata, NaN, infinite) take the value of the last valid sample to their
// left, else of the next to their right, else of the nearest row that has any; `filled` counts them. Throws
// Error(io) naming the file, Error(usage) for a crop outside the raster or a raster without valid samples.
Raster read_raster(const std::string& file, const std::optional<Crop>& crop, std::size_t& filled,
                   int band = 1);

// Cuts into tiles of at most `size` x `size` in rows; 0: one tile, the whole.
std::vector<Raster> cut_tiles(const Raster& raster, int size);
// The inverse, into a raster of the right shape.
void join_tiles(const std::vector<Raster>& tiles, int size, Raster& out);

struct Errors {
    double max = 0, rms = 0;
};
Errors compare(const Raster& a, const Raster& b);

}  // namespace carat::bench
