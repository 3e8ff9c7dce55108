// Plain images that GDAL does not know (EXR, HDR, ...), read with OpenImageIO.
#pragma once

#include "raster_file.hpp"

namespace carat {

// Nothing if OpenImageIO cannot open it either.
std::unique_ptr<RasterFile> open_image_raster(const std::string& path, const LayerOptions& options);

}  // namespace carat
