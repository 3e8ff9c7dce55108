// Global rasters whose values are the difficulty.
#include <cmath>
#include <limits>

#include "dual.hpp"
#include "hash.hpp"
#include "layer.hpp"

namespace carat::synth {
namespace {

constexpr double kRadius = 6371007.2;  // metres
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Layer global(const char* name, const char* purpose, const char* truth_text, int columns, Height truth) {
    return make_layer(name, purpose, truth_text, global_grid(columns, epsg(4326, true)),
                      degree_spacing(360.0 / columns, kRadius), std::move(truth));
}

double gentle(const Vec3& n) { return 3000 * n[2] + 1000 * n[0]; }

/// Cones of 8000 m and 0.75 degrees on the poles and on the antimeridian at multiples of 30 degrees.
Height spikes() {
    std::vector<Vec3> tips;
    for (int latitude = -90; latitude <= 90; latitude += 30)
        tips.push_back(direction(Geodetic{.latitude = static_cast<double>(latitude), .longitude = 180}));
    return [tips](const Vec3& n) {
        constexpr double kBase = 0.0130899694;  // chord of 0.75 degrees
        double h = 0;
        for (const Vec3& t : tips) {
            const Vec3 d{n[0] - t[0], n[1] - t[1], n[2] - t[2]};
            h = std::max(h, 8000 * (1 - length(d) / kBase));
        }
        return h;
    };
}

double cliff(const Vec3& n) {
    const double x = std::abs(n[0]), y = std::abs(n[1]), z = std::abs(n[2]);
    if (x >= y && x >= z) return 0;
    return y >= z ? 10000 : -10000;
}

/// A uniform number in [0, 1) for the pixel of a grid that holds n.
double pixel_chance(const Grid& grid, const Vec3& n, std::uint64_t seed) {
    const auto [c, r] = grid.pixel(n);
    return unit(lattice_hash(c, r, 0, seed), 0);
}

Layer checkerboard() {
    const Grid grid = global_grid(720, epsg(4326, true));
    return global("checkerboard.tif", "the sampling limit",
                  "+1000 m where column + row is even, else -1000 m", 720, [grid](const Vec3& n) {
                      const auto [c, r] = grid.pixel(n);
                      return (c + r) % 2 == 0 ? 1000.0 : -1000.0;
                  });
}

Layer nonfinite(std::uint64_t seed) {
    const Grid grid = global_grid(720, epsg(4326, true));
    return global("nonfinite.tif", "NaN and infinities without a NODATA value",
                  "3000 n_z + 1000 n_x; by pixel 2 % NaN, 1 % +infinity, 1 % -infinity", 720,
                  [grid, seed](const Vec3& n) {
                      const double chance = pixel_chance(grid, n, seed);
                      if (chance < 0.02) return kNan;
                      if (chance < 0.03) return kInfinity;
                      return chance < 0.04 ? -kInfinity : gentle(n);
                  });
}

Layer extremes(std::uint64_t seed) {
    const Grid grid = global_grid(360, epsg(4326, true));
    Layer l =
        global("int16.tif", "the ends of int16 as real heights",
               "3000 n_z + 1000 n_x; by pixel 10 % -32768, 10 % 32767", 360, [grid, seed](const Vec3& n) {
                   const double chance = pixel_chance(grid, n, seed);
                   if (chance < 0.1) return -32768.0;
                   return chance < 0.2 ? 32767.0 : gentle(n);
               });
    l.info.type = SampleType::int16;
    return l;
}

Layer nothing() {
    Layer l =
        global("nodata.tif", "no valid sample", "NODATA everywhere", 360, [](const Vec3&) { return kNan; });
    l.info.nodata = -9999;
    return l;
}

}  // namespace

std::vector<Layer> value_layers(Kind kind, const Options& options) {
    const std::uint64_t seed = stream_seed(options.seed, static_cast<std::uint64_t>(kind));
    switch (kind) {
        case Kind::spikes:
            return {global("spikes.tif", "poles and antimeridian",
                           "cones of 8000 m and 0.75 degrees on the poles and at 180 E, every 30 degrees",
                           1440, spikes())};
        case Kind::cliff:
            return {global("cliff.tif", "cube edges",
                           "0, 10000, -10000 m where |n_x|, |n_y|, |n_z| is largest (first of equals)", 1440,
                           cliff)};
        case Kind::checkerboard:
            return {checkerboard()};
        case Kind::constant:
            return {
                global("constant.tif", "one height", "1234.5 m", 360, [](const Vec3&) { return 1234.5; })};
        case Kind::nodata:
            return {nothing()};
        case Kind::nonfinite:
            return {nonfinite(seed)};
        case Kind::int16:
            return {extremes(seed)};
        case Kind::onepixel:
            return {make_layer("onepixel.tif", "the smallest raster", "777 m", degree_grid(10, 46, 1, 1, 1),
                               degree_spacing(1, kRadius), [](const Vec3&) { return 777.0; })};
        default:
            return {};
    }
}

}  // namespace carat::synth
