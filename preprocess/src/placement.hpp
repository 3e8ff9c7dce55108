// Where each file of a layer lies, and which files share a grid.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "carat/preprocess/layer.hpp"
#include "frame.hpp"
#include "grid.hpp"
#include "raster_file.hpp"

namespace carat {

struct PlacedFile {
    const RasterFile* file = nullptr;
    std::string wkt;  // "" for plain longitude and latitude
    std::shared_ptr<const Crs> crs;
    std::array<double, 6> transform{};
};

// Where a layer's files lie, by their own georeferences or by options.bounds. Files of equal WKT share a Crs.
// Throws Error(usage).
std::vector<PlacedFile> place(const std::vector<std::unique_ptr<RasterFile>>& files,
                              const LayerOptions& options, const Ellipsoid& body,
                              std::vector<std::string>& warnings);

struct GridPlan {
    std::shared_ptr<const Crs> crs;
    std::array<double, 6> transform{};
    std::int64_t width = 0, height = 0;
    std::vector<GridPart> parts;
};

// Consecutive files with equal CRS, type, scale and pixel size, offset by whole pixels (within 0.01), share a
// grid.
std::vector<GridPlan> plan_grids(const std::vector<PlacedFile>& files);

// Outer edges of a file in degrees.
GeoBounds bounds_of(const Frame& frame);
// The least longitudes and latitudes that contain all.
GeoBounds united(const std::vector<GeoBounds>& all);

}  // namespace carat
