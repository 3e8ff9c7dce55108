// Rasters whose place and orientation are the difficulty, and files that cannot be read.
#include <cmath>
#include <numbers>

#include "layer.hpp"

namespace carat::synth {
namespace {

constexpr double kRadius = 6371007.2;  // metres

Layer relief(const char* name, const char* purpose, Grid grid, double spacing_m, const Options& options,
             double raised_m = 0) {
    const double limit = std::max(kFinestWavelength, 2 * spacing_m);
    Height truth = [raised_m, formula = earthlike(options.seed, limit)](const Vec3& n) {
        return formula(n) + raised_m;
    };
    Layer l = make_layer(name, purpose, "earthlike_height(n, seed, min_wavelength_m)", std::move(grid),
                         spacing_m, std::move(truth));
    if (raised_m != 0) l.info.truth_text += " + " + std::to_string(static_cast<int>(raised_m)) + " m";
    l.info.min_wavelength_m = limit;
    return l;
}

Layer degrees(const char* name, const char* purpose, double west, double north, double step, int width,
              int height, const Options& options, double raised_m = 0) {
    return relief(name, purpose, degree_grid(west, north, step, width, height), degree_spacing(step, kRadius),
                  options, raised_m);
}

std::vector<Layer> overlap(const Options& options) {
    const char* purpose = "one of three overlapping layers of equal resolution";
    return {degrees("overlap_a.tif", purpose, 10, 50, 0.05, 200, 200, options),
            degrees("overlap_b.tif", purpose, 15, 50, 0.05, 200, 200, options, 100),
            degrees("overlap_c.tif", purpose, 12.5, 45, 0.05, 200, 200, options, 200)};
}

std::vector<Layer> antimeridian(const Options& options) {
    std::vector<Layer> layers;
    layers.push_back(relief("antimeridian_utm.tif", "across 180 degrees in UTM zone 1",
                            grid_around(epsg(32601, false), {.latitude = 50, .longitude = 180}, 500, 512),
                            500, options));
    layers.push_back(degrees("antimeridian.tif", "across 180 degrees, longitudes 175 to 185", 175, 10,
                             1.0 / 25, 250, 250, options));
    return layers;
}

std::vector<Layer> polar(const Options& options) {
    const auto cap = [&](const char* name, const char* purpose, int code) {
        const Grid grid{250, 250, {-1e6, 8000, 0, 1e6, 0, -8000}, epsg(code, false)};
        return relief(name, purpose, grid, 8000, options);
    };
    return {cap("polar_north.tif", "the north pole in polar stereographic projection", 3995),
            cap("polar_south.tif", "the south pole in polar stereographic projection", 3031)};
}

Layer rotated(const Options& options) {
    constexpr double kStep = 0.04, kAngle = std::numbers::pi / 6;
    const double c = kStep * std::cos(kAngle), s = kStep * std::sin(kAngle);
    const Grid grid{200, 150, {28, c, s, 20, s, -c}, epsg(4326, true)};
    return relief("rotated.tif", "rows and columns at 30 degrees to the meridians", grid,
                  degree_spacing(kStep, kRadius), options);
}

Layer broken(const char* name, const char* purpose, int width, Damage damage, const Options& options) {
    Layer l = degrees(name, purpose, 0, 10, 0.01, width, width, options);
    l.info.readable = false;
    l.damage = damage;
    return l;
}

}  // namespace

std::vector<Layer> placement_layers(Kind kind, const Options& options) {
    switch (kind) {
        case Kind::overlap:
            return overlap(options);
        case Kind::antimeridian:
            return antimeridian(options);
        case Kind::polar:
            return polar(options);
        case Kind::rotated:
            return {rotated(options)};
        default:
            return {};
    }
}

std::vector<Layer> damaged_layers(Kind kind, const Options& options) {
    if (kind == Kind::empty) return {broken("empty.tif", "a file of 0 bytes", 1, Damage::empty, options)};
    return {broken("truncated_header.tif", "cut after 100 bytes", 64, Damage::cut_header, options),
            broken("truncated_data.tif", "its last quarter is gone", 256, Damage::cut_data, options)};
}

}  // namespace carat::synth
