// The layers of earth and moon.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "hash.hpp"
#include "layer.hpp"
#include "noise.hpp"
#include "sites.hpp"

namespace carat::synth {
namespace {

constexpr double kEarthRadius = 6371007.2;  // metres, authalic
constexpr double kMoonRadius = 1737400;
constexpr int kEarthColumns = 4320;
constexpr int kMoonColumns = 2880;
constexpr double kVoid = -32768;
constexpr std::uint64_t kVoidStream = 0x601d;

double wavelength(const Options& options, double spacing_m) {
    if (options.min_wavelength_m > 0) return options.min_wavelength_m;
    return std::max(kFinestWavelength, 2 * spacing_m);
}

Layer relief_layer(const char* name, const char* purpose, const char* formula, Grid grid, double spacing_m,
                   const Options& options, Height (*make)(std::uint64_t, double)) {
    const double limit = wavelength(options, spacing_m);
    Layer l = make_layer(name, purpose, std::string(formula) + "(n, seed, min_wavelength_m)", std::move(grid),
                         spacing_m, make(options.seed, limit));
    l.info.min_wavelength_m = limit;
    l.info.type = options.type;
    return l;
}

/// NaN in a few per cent of places, in blobs some kilometres across.
Height with_voids(Height height, std::uint64_t seed) {
    auto blobs = std::make_shared<const std::vector<Octave>>(
        make_octaves({9e3, 500, 2.1}, 100, kEarthRadius, stream_seed(seed, kVoidStream)));
    return [height = std::move(height), blobs](const Vec3& n) {
        const bool hole = fractal(*blobs, n, 0.5).v > 0.45;
        return hole ? std::numeric_limits<double>::quiet_NaN() : height(n);
    };
}

int inset_columns(const Options& options, int own) { return options.inset_size ? options.inset_size : own; }

Grid square_around(const Geodetic& g, double step, int width) {
    const auto snap = [&](double degrees) { return std::round(degrees / step) * step; };
    return degree_grid(snap(g.longitude) - step * width / 2, snap(g.latitude) + step * width / 2, step, width,
                       width);
}

}  // namespace

std::vector<Layer> earth_layers(const Options& options) {
    const Sites sites = find_sites(options.seed);
    const char* formula = "earthlike_height";
    const auto layer = [&](const char* name, const char* purpose, Grid grid, double spacing_m) {
        return relief_layer(name, purpose, formula, std::move(grid), spacing_m, options, earthlike);
    };
    std::vector<Layer> layers;
    layers.push_back(layer("earth_summit_utm10m.tif", "10 m inset in UTM on a summit",
                           utm_grid(sites.summit, 10, inset_columns(options, 1000)), 10));
    layers.push_back(layer("earth_coast_0p5s.tif", "0.5 arc-second inset over a coast",
                           square_around(sites.coast, 1.0 / 7200, inset_columns(options, 1080)),
                           degree_spacing(1.0 / 7200, kEarthRadius)));
    layers.push_back(layer("earth_range_3s.tif",
                           "3 arc-second inset over a mountain range, with NODATA voids",
                           square_around(sites.summit, 1.0 / 1200, inset_columns(options, 1200)),
                           degree_spacing(1.0 / 1200, kEarthRadius)));
    Written& range = layers.back().info;
    range.nodata = kVoid;
    range.truth = with_voids(range.truth, options.seed);
    range.truth_text += ", NODATA in voids";
    const int columns = options.size ? options.size : kEarthColumns;
    layers.push_back(layer("earth_global.tif", "the whole planet", global_grid(columns, epsg(4326, true)),
                           degree_spacing(360.0 / columns, kEarthRadius)));
    return layers;
}

std::vector<Layer> moon_layers(const Options& options) {
    const auto layer = [&](const char* name, const char* purpose, Grid grid) {
        const double spacing_m = degree_spacing(grid.transform[1], kMoonRadius);
        grid.crs = moon_crs();
        return relief_layer(name, purpose, "moonlike_height", std::move(grid), spacing_m, options, moonlike);
    };
    std::vector<Layer> layers;
    layers.push_back(
        layer("moon_inset.tif", "inset of 128 pixels per degree",
              square_around({.latitude = -43, .longitude = -11}, 1.0 / 128, inset_columns(options, 768))));
    const int columns = options.size ? options.size : kMoonColumns;
    layers.push_back(layer("moon_global.tif", "the whole body", global_grid(columns, moon_crs())));
    return layers;
}

}  // namespace carat::synth
