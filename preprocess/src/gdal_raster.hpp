// Rasters read with GDAL.
#pragma once

#include "raster_file.hpp"

namespace carat {

std::unique_ptr<RasterFile> open_gdal_raster(const std::string& path, const LayerOptions& options,
                                             HandlePool& handles, std::vector<std::string>& warnings);

}  // namespace carat
