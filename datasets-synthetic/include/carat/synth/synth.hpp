// Analytic planets and hostile inputs, written as GeoTIFF.
//
// The height at any point is a closed formula of the geodetic normal n, so a test knows the truth everywhere,
// not only at samples. Everything random is hashed from a seed; the same call writes the same bytes.
//
//   n         unit vector (geodetic normal): +x at 0 N 0 E, +y at 0 N 90 E, +z north
//   heights   metres above the body's ellipsoid along n; NaN where a file holds no data
//   lengths   metres, angles degrees; bounds are west, south, east, north of the outer pixel edges
//   rasters   pixel-is-area: pixel (column c, row r) holds the truth at its centre (c + 1/2, r + 1/2),
//   rounded to
//             float32, or to whole metres (halves away from zero) for int16
//   files     tiled, DEFLATE; a file takes its name only when complete; manifest.json lists them
//
// The relief formulas use + - * / sqrt and floor alone: without floating contraction they give the same bits
// with every compiler. The rasters also depend on sin, cos and PROJ through the position of a pixel.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "carat/globe/ellipsoid.hpp"

namespace carat::synth {

/// Height in metres at a unit geodetic normal. Pure and thread-safe.
using Height = std::function<double(const std::array<double, 3>&)>;

inline constexpr double kFinestWavelength = 20;  ///< metres: octaves of the default planet stop here

/// An Earth that never was: plates, continents with shelves, ranges cut by valleys, plateaus, craters,
/// spreading ridges with faults, trenches, seamounts. -10,800 < h < 8500 m; 65 to 75 % lie below 0.
///
/// Detail is a ladder of octaves. Those of wavelength L (lattice period, metres) at or below
/// `min_wavelength_m` are left out and those between once and twice that fade in, so formulas of different
/// `min_wavelength_m` agree in all coarser octaves. Crests and furrows are smooth but not strictly
/// band-limited. Throws Error(usage) unless min_wavelength_m is at least 1.
Height earthlike(std::uint64_t seed, double min_wavelength_m = kFinestWavelength);
/// A cratered sphere of the Moon's radius: highlands, flooded basins, craters with rims, aprons and central
/// peaks. -9500 < h < 10,500 m. Craters of radius at or below `min_wavelength_m` are left out.
Height moonlike(std::uint64_t seed, double min_wavelength_m = kFinestWavelength);

/// earthlike() at one point. Keeps the last planet used by the thread (making one costs tens of
/// milliseconds).
double earthlike_height(const std::array<double, 3>& n, std::uint64_t seed,
                        double min_wavelength_m = kFinestWavelength);
/// moonlike() at one point, likewise.
double moonlike_height(const std::array<double, 3>& n, std::uint64_t seed,
                       double min_wavelength_m = kFinestWavelength);

enum class Kind {
    earth,
    moon,
    spikes,
    cliff,
    checkerboard,
    constant,
    nodata,
    nonfinite,
    int16,
    onepixel,
    overlap,
    antimeridian,
    polar,
    rotated,
    empty,
    truncated,
    hostile,  ///< every kind after moon, in one directory
};

struct KindInfo {
    Kind kind;
    const char* name;
    const char* description;  ///< one line
};
std::span<const KindInfo> kinds();
/// Throws Error(usage) naming the known kinds.
Kind kind_of(const std::string& name);

enum class SampleType { float32, int16 };

struct Options {
    std::uint64_t seed = 1;
    /// Columns of the global raster of earth and moon, even, 2..86400 (rows are half); 0: the kind's own
    /// default.
    int size = 0;
    int inset_size =
        0;  ///< columns and rows of each inset of earth and moon, 2..20000; 0: the kind's own default
    SampleType type = SampleType::float32;  ///< of earth and moon
    /// Of every file of earth and moon, metres; 0: twice the sample spacing of each file, at least
    /// kFinestWavelength.
    double min_wavelength_m = 0;
    bool overwrite = false;
    /// Called from the calling thread now and then with samples done and in all; false ends the work with an
    /// Error.
    std::function<bool(std::uint64_t done, std::uint64_t total)> progress;
};

struct Planet {
    std::string name;
    Ellipsoid body;
    Height height;
};
/// The truth of a kind. Of earth and moon: the formula itself, min_wavelength_m 0 meaning kFinestWavelength;
/// of any other kind: its first file's. Throws Error(usage) for Kind::hostile, which has no one truth.
Planet planet(Kind kind, const Options& options = {});

struct Bounds {
    double west, south, east, north;  ///< east may pass 180 where a raster crosses the antimeridian
};

/// A file that write() made. Files come in layer order: where they overlap, an earlier one has priority.
struct Written {
    std::string name;  ///< inside the directory
    std::string purpose;
    std::string truth_text;  ///< the formula in words
    bool readable = true;    ///< false: opening or reading it must give an error
    int width = 0;
    int height = 0;
    Bounds bounds{};
    double spacing_m = 0;         ///< between samples, from north to south, nominal
    double min_wavelength_m = 0;  ///< 0: the formula has no octaves
    std::string crs;
    SampleType type = SampleType::float32;
    std::optional<double> nodata;
    Height truth;  ///< what the sample nearest to n was rounded from; NaN where the file holds no data
};

/// Writes the files of a kind and manifest.json into `directory` (made if missing). Uses oneTBB's threads.
/// Throws Error(usage) for options out of range or files that exist already (nothing is written then),
/// Error(io) when writing fails; no half-written file stays.
std::vector<Written> write(Kind kind, const std::filesystem::path& directory, const Options& options = {});

}  // namespace carat::synth
