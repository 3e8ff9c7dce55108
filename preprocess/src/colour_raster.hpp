// One component of YCoCg-R of a raster's red, green and blue.
#pragma once

#include "raster_file.hpp"

namespace carat {

// Opens the bands that LayerOptions::colour_component wants. Throws as RasterFile::open(), and
// Error(unsupported) if they are not 8-bit.
std::unique_ptr<RasterFile> open_colour_raster(const std::string& path, const LayerOptions& options,
                                               HandlePool& handles, std::vector<std::string>& warnings);

}  // namespace carat
