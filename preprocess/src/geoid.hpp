// Geoid heights: what turns a height above the geoid into one above the ellipsoid.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "carat/globe/ellipsoid.hpp"
#include "carat/preprocess/layer.hpp"
#include "raster_file.hpp"
#include "tile_cache.hpp"

namespace carat {

// Thread-safe.
class Geoid {
  public:
    // A GeographicLib .pgm file (cubic interpolation), or a raster in metres (bilinear). `key` as for a Grid.
    // Throws Error naming the file.
    static std::unique_ptr<Geoid> open(const std::string& path, const Ellipsoid& body, HandlePool& handles,
                                       TileCache& cache, std::uint64_t key,
                                       std::vector<std::string>& warnings);
    virtual ~Geoid() = default;

    // Adds the geoid's height at each place (degrees) to the height there; clears `valid` where it has none.
    virtual void add(std::span<const double> lat, std::span<const double> lon, std::span<double> heights,
                     std::span<std::uint8_t> valid) const = 0;
};

}  // namespace carat
