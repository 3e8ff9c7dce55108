// One layer: its rasters, gathered into grids, and its geoid.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cap.hpp"
#include "carat/preprocess/layer.hpp"
#include "geoid.hpp"
#include "grid.hpp"
#include "raster_file.hpp"

namespace carat {

// Grids take keys from `key` on; a layer never has more than this many.
inline constexpr std::uint64_t kKeysPerLayer = 1 << 16;

struct LayerOpening {
    bool lazy = false;  // looks for holes where it must, and does not count samples
    bool hash = true;   // contents of the files
};

// Thread-safe once made.
class SourceLayer {
  public:
    SourceLayer(const LayerOptions& options, const Ellipsoid& body, HandlePool& handles, TileCache& cache,
                std::uint64_t key, std::vector<std::string>& warnings, const LayerOpening& opening = {});

    // Heights at places in degrees, all inside cap, and 1 or 0 for a hole; geoid included. With weights (not
    // empty), also by how much the layer covers what lies below it, 0..1.
    void sample(std::span<const double> lat, std::span<const double> lon, const Cap& cap,
                std::span<double> heights, std::span<std::uint8_t> valid, std::span<double> weights) const;
    // As Grid::cover, over all grids.
    Coverage cover(std::span<const Vec3> places, const Cap& cap) const;
    bool may_meet(const Cap& cap) const;

    const Geoid* geoid() const { return geoid_.get(); }
    // In priority order.
    const std::vector<std::unique_ptr<Grid>>& grids() const { return grids_; }
    Resampling resampling() const { return resampling_; }
    const LayerInfo& info() const { return info_; }

  private:
    void sample_chunk(std::span<const double> lat, std::span<const double> lon, const Cap& cap,
                      std::span<double> heights, std::span<std::uint8_t> valid,
                      std::span<double> weights) const;

    Resampling resampling_;
    std::vector<std::unique_ptr<RasterFile>> files_;
    std::vector<std::unique_ptr<Grid>> grids_;
    std::unique_ptr<Geoid> geoid_;
    LayerInfo info_;
};

// Nominal spacing in metres of the finest file of a layer. Throws as SourceLayer does.
double nominal_spacing(const LayerOptions& options, const Ellipsoid& body, HandlePool& handles);

}  // namespace carat
