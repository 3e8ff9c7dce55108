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

// Slope of a monotone curve at a band, from the slopes of the two intervals beside it and their widths
// (Fritsch and Butland 1984): zero at an extremum, so that no colour overshoots.
double monotone_slope(double before, double after, double width_before, double width_after) {
    if (before * after <= 0) return 0;
    const double w = (width_before + 2 * width_after) / (3 * (width_before + width_after));
    return before * after / (w * after + (1 - w) * before);
}

// The bands' colours at one height as a smooth curve over latitude: a kink would show as a stripe around the
// body.
double in_bands(const std::vector<ColourBand>& bands, double latitude, double height, std::size_t channel) {
    const auto value = [&](std::size_t b) { return in_band(bands[b], height)[channel]; };
    const auto width = [&](std::size_t b) { return bands[b + 1].latitude - bands[b].latitude; };
    const auto slope = [&](std::size_t b) { return (value(b + 1) - value(b)) / width(b); };
    const auto tangent = [&](std::size_t b) {
        return b == 0 || b + 1 == bands.size()
                   ? 0
                   : monotone_slope(slope(b - 1), slope(b), width(b - 1), width(b));
    };
    if (latitude <= bands.front().latitude) return value(0);
    if (latitude >= bands.back().latitude) return value(bands.size() - 1);
    std::size_t b = 0;
    while (bands[b + 1].latitude <= latitude) ++b;
    const double w = width(b), t = (latitude - bands[b].latitude) / w;
    const double rise = t * t * (3 - 2 * t);
    return value(b) * (1 - rise) + value(b + 1) * rise +
           w * t * (1 - t) * ((1 - t) * tangent(b) - t * tangent(b + 1));
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
    std::array<float, 3> linear{};
    for (std::size_t k = 0; k < 3; ++k) {
        linear[k] = srgb_decode(
            static_cast<float>(in_bands(sea ? table.sea : table.land, latitude, height, k) / 255));
    }
    return linear;
}

}  // namespace carat
