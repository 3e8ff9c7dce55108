// What a SourceStack is made of.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "blend.hpp"
#include "carat/preprocess/source.hpp"
#include "source_layer.hpp"
#include "tile_cache.hpp"

namespace carat {

struct SourceStack::State {
    State(const Ellipsoid& b, double height, std::size_t cache_bytes)
        : body(b), base_height(height), cache(cache_bytes / 4 * 3) {}

    void sample_chunk(std::span<const Vec3> n, std::span<double> heights, std::span<std::int8_t> layer,
                      std::span<double> weights) const;
    // At most kChunk places in degrees, all inside cap; lat and lon are used up.
    void sample_degrees(std::span<double> lat, std::span<double> lon, const Cap& cap,
                        std::span<double> heights, std::span<std::int8_t> layer,
                        std::span<double> weights) const;
    void add_base(const Blend& blend, std::span<const double> lat, std::span<const double> lon,
                  std::span<const std::size_t> index, std::span<double> heights) const;
    double finest(const Half& half) const;
    double finest_in_small(const Half& half, int more_levels) const;
    bool may_meet(const Cap& cap) const;

    Ellipsoid body;
    double base_height;
    HandlePool handles;
    TileCache cache;
    std::vector<std::string> warnings;
    std::vector<std::unique_ptr<SourceLayer>> layers;
    std::vector<LayerInfo> infos;
};

}  // namespace carat
