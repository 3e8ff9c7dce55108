#include "carat/vulkan/colour_table.hpp"

#include <algorithm>
#include <cmath>

#include "carat/globe/error.hpp"
#include "carat/vulkan/picture.hpp"

namespace carat {

namespace {

using Colour = std::array<double, 3>;  // sRGB-encoded, 0 to 255

Colour mix(const Colour& a, const Colour& b, double t) {
    Colour c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = a[k] + (b[k] - a[k]) * t;
    return c;
}

Colour to_colour(const ColourStop& s) { return {double(s.srgb[0]), double(s.srgb[1]), double(s.srgb[2])}; }

Colour in_band(const ColourBand& band, double height) {
    const auto above = std::upper_bound(band.stops.begin(), band.stops.end(), height,
                                        [](double h, const ColourStop& s) { return h < s.height; });
    if (above == band.stops.begin()) return to_colour(band.stops.front());
    if (above == band.stops.end()) return to_colour(band.stops.back());
    const ColourStop& below = *(above - 1);
    return mix(to_colour(below), to_colour(*above), (height - below.height) / (above->height - below.height));
}

Colour in_bands(const std::vector<ColourBand>& bands, double latitude, double height) {
    const auto above = std::upper_bound(bands.begin(), bands.end(), latitude,
                                        [](double l, const ColourBand& b) { return l < b.latitude; });
    if (above == bands.begin()) return in_band(bands.front(), height);
    if (above == bands.end()) return in_band(bands.back(), height);
    const ColourBand& below = *(above - 1);
    return mix(in_band(below, height), in_band(*above, height),
               (latitude - below.latitude) / (above->latitude - below.latitude));
}

[[noreturn]] void refuse(const ColourTable& table, const std::string& why) {
    throw Error(ErrorCode::usage, "colour table '" + table.name + "': " + why);
}

void check_bands(const ColourTable& table, const std::vector<ColourBand>& bands) {
    if (bands.empty()) refuse(table, "no bands");
    for (std::size_t b = 0; b < bands.size(); ++b) {
        if (!std::isfinite(bands[b].latitude) || (b > 0 && !(bands[b - 1].latitude < bands[b].latitude))) {
            refuse(table, "latitudes must ascend");
        }
        const auto& stops = bands[b].stops;
        if (stops.size() < 2) refuse(table, "a band needs at least two stops");
        for (std::size_t s = 0; s < stops.size(); ++s) {
            if (!std::isfinite(stops[s].height) || (s > 0 && !(stops[s - 1].height < stops[s].height))) {
                refuse(table, "heights must ascend");
            }
        }
    }
}

}  // namespace

void check_colours(const ColourTable& table) {
    check_bands(table, table.land);
    if (table.sea_level) check_bands(table, table.sea);
}

std::array<float, 3> colour_at(const ColourTable& table, double latitude, double height) {
    const bool sea = table.sea_level && height <= *table.sea_level;
    const Colour c = in_bands(sea ? table.sea : table.land, latitude, height);
    return {srgb_decode(static_cast<float>(c[0] / 255)), srgb_decode(static_cast<float>(c[1] / 255)),
            srgb_decode(static_cast<float>(c[2] / 255))};
}

}  // namespace carat
