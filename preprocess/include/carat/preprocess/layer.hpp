// Layers: what the user names on the command line, and what was found in the files.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace carat {

// How a height between samples comes from the samples; the rules stand in source.hpp.
enum class Resampling { nearest, bilinear, cubic };
// "nearest", "bilinear", "cubic". Throws Error(usage) otherwise.
Resampling parse_resampling(const std::string& text);
const char* to_string(Resampling r);

// Which latitude a geographic CRS of another body than the Earth speaks of.
enum class LatitudeKind {
    automatic,  // geocentric if the CRS's name says "ocentric" or "planetocentric", else geodetic
    geodetic,
    geocentric,
};

// One layer: any number of rasters. Where rasters of a layer overlap, the first one named with a valid sample
// there wins.
struct LayerOptions {
    std::vector<std::string> files;  // anything GDAL opens, or, with bounds, an image that OpenImageIO opens
    // Raw value that is a hole, besides the file's own NODATA tag and mask.
    std::optional<double> nodata = std::nullopt;
    // Heights in metres (before the geoid) outside [first, second] are holes.
    std::optional<std::array<double, 2>> valid_range = std::nullopt;
    // W, S, E, N in degrees, the outer edges of the outer pixels; E <= W crosses 180. Only for files without
    // a georeference of their own, else Error(usage).
    std::optional<std::array<double, 4>> bounds = std::nullopt;
    // Heights are above this geoid: its height is added. A GeographicLib .pgm file or a raster in metres; ""
    // for none.
    std::string geoid = {};
    Resampling resampling = Resampling::bilinear;
    // Width in metres over which the layer fades into the layers below at its holes and borders (source.hpp);
    // 0: not at all; by default four samples. At most 64 samples, else cut to that with a warning.
    std::optional<double> feather = std::nullopt;
    // The same at outer edges alone; by default `feather` if that is given, else a sixteenth of the raster's
    // shorter side, 16 to 64 samples. At most a quarter of the shorter side, else cut to that with a warning.
    std::optional<double> feather_edges = std::nullopt;
    int band = 1;  // counted from 1
    LatitudeKind latitude = LatitudeKind::automatic;
    // The values are one component of a colour instead of a band: 0 Y, 1 Co, 2 Cg of YCoCg-R of the 8-bit
    // bands 1 to 3 (of one band: grey). A pixel that is a hole in any of them is one.
    std::optional<int> colour_component = std::nullopt;
};

// West > east where the region crosses 180.
struct GeoBounds {
    double west = 0, south = 0, east = 0, north = 0;  // degrees

    friend bool operator==(const GeoBounds&, const GeoBounds&) = default;
};

struct FileInfo {
    std::string path;            // as given
    std::string driver;          // GDAL's short name, or "OpenImageIO:<format>"
    std::string crs;             // WKT; "" for --bounds and assumed latitude-longitude
    int width = 0, height = 0;   // samples
    std::uint64_t bytes = 0;     // of all files that make up the dataset (a VRT and what it names)
    std::uint64_t hash = 0;      // XXH3 of their contents, in the order GDAL lists them
    GeoBounds bounds{};          // outer edges of the outer pixels
    double spacing = 0;          // metres, by the spacing rule at the middle of the raster
    std::string transformation;  // PROJ's name of the datum transformation; "" if none was needed
};

struct LayerInfo {
    std::string name;  // the first file's name without folder
    std::vector<FileInfo> files;
    GeoBounds bounds{};  // of all files
    double spacing =
        std::numeric_limits<double>::infinity();  // metres, finest of the files' nominal spacings
    std::uint64_t samples = 0;                    // source samples, overlaps of aligned files once
    std::uint64_t valid_samples = 0;              // of these, not holes
    std::string geoid;

    double valid_share() const {
        return samples == 0 ? 0 : static_cast<double>(valid_samples) / static_cast<double>(samples);
    }
};

}  // namespace carat
