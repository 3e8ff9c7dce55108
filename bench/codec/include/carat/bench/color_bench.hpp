// 8-bit RGB through the reversible colour transform YCoCg-R and the codec's kernel, against JPEG XL.
//
//   Co = R - B;  t = B + (Co >> 1);  Cg = G - t;  Y = t + (Cg >> 1)          (Malvar and Sullivan 2003)
//   t = Y - (Cg >> 1);  G = Cg + t;  B = t - (Co >> 1);  R = B + Co
//
// Tolerances of the components. Let the components be off by at most y, co, cg (integers). x >> 1 is a floor,
// so an error e of x moves x >> 1 by floor(e/2) or ceil(e/2), which leaves at most ceil(|e|/2) of e in e - d
// as well:
//
//   t   off by at most y + ceil(cg/2)
//   G = Cg + t = Y + (Cg - (Cg >> 1))     y + ceil(cg/2)
//   B = t - (Co >> 1)                     y + ceil(cg/2) + ceil(co/2)
//   R = t + (Co - (Co >> 1))              y + ceil(cg/2) + ceil(co/2)
//
// so y + ceil(cg/2) + ceil(co/2) <= E keeps every channel within E; even cg and co waste nothing. Clamping to
// [0, 255] afterwards only helps. Among the splits of E the one with the smallest file is taken.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "carat/bench/raster.hpp"

namespace carat::bench {

using Rgb = std::array<Raster, 3>;

// Bands 1 to 3. Throws Error(unsupported) if they are not 8-bit.
Rgb read_rgb(const std::string& file, const std::optional<Crop>& crop);

struct ColorRow {
    std::string codec, setting;
    std::size_t bytes = 0;
    double bits_per_pixel = 0;
    int max_error = 0;  // of any channel, measured after decoding, of 255
    double rms_error = 0;
    double encode_rate = 0, decode_rate = 0;  // pixels a second
};

struct ColorOptions {
    int tolerance = 10;  // of 255
    // Called before each measurement; false throws Error(usage) "cancelled".
    std::function<bool(const std::string& what, std::size_t done, std::size_t total)> progress = {};
};

// Carat in modes 0, 1, 2; JPEG XL lossy at the greatest distance whose measured error keeps the tolerance;
// JPEG XL lossless on channels quantised with step 2 E + 1. One thread.
std::vector<ColorRow> bench_color(const Rgb& image, const ColorOptions& options);

// The transform, for tests. Components are y, co, cg.
std::array<std::int16_t, 3> ycocg_of_rgb(const std::array<std::int16_t, 3>& rgb);
std::array<std::int16_t, 3> rgb_of_ycocg(const std::array<std::int16_t, 3>& y_co_cg);

struct ComponentTolerances {
    int y = 0, co = 0, cg = 0;
};
// All splits of E that waste nothing, from all in y to none.
std::vector<ComponentTolerances> component_tolerances(int tolerance);

}  // namespace carat::bench
