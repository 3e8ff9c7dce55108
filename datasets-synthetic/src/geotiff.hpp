// A layer to a GeoTIFF: samples computed in parallel by strips of rows, written in order.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "layer.hpp"

namespace carat::synth {

/// Writes layer.info.name into `directory` under a temporary name and renames it. Calls `advance` with the
/// number of samples done since the last call. Throws Error(io); leaves nothing behind then.
void write_geotiff(const Layer& layer, const std::filesystem::path& directory,
                   const std::function<void(std::uint64_t)>& advance);

}  // namespace carat::synth
