// Hypsometric colours by latitude and height, as data that people can edit.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace carat {

// A colour at a height: metres above the datum surface, sRGB-encoded 0 to 255.
struct ColourStop {
    double height = 0;
    std::array<std::uint8_t, 3> srgb{};
};

// The colours of one geodetic latitude (degrees, north positive), by ascending height.
struct ColourBand {
    double latitude = 0;
    std::vector<ColourStop> stops;
};

// Bands by ascending latitude. Encoded colours are interpolated linearly between stops and by a smooth curve
// without overshoot (monotone cubic) between bands; beyond the first and last they are constant. One band
// makes a table of height alone.
struct ColourTable {
    std::string name;
    std::optional<double> sea_level;  // metres; heights up to it take the sea's colours
    std::vector<ColourBand> sea;      // used where sea_level is given
    std::vector<ColourBand> land;
};

const ColourTable& earth_colours();
const ColourTable& moon_colours();
const ColourTable& mars_colours();
const ColourTable& grey_colours();
// By the name of a body, "earth", "moon", "mars"; grey for any other.
const ColourTable& colours_of(const std::string& body);

// A table from a colour file: GDAL's colour-relief text ("height red green blue" a line, or a colour's name)
// or GMT's palette (.cpt: "height colour height colour", RGB, RANGE and HINGE obeyed). A line "latitude DEG"
// begins a band of its own, in either. A jump of the colour at height 0 makes it the sea level. Lines for no
// data are passed over. Throws Error(io), Error(corrupt) or Error(unsupported) (percentages, HSV), naming
// file and line.
ColourTable read_colours(const std::string& path);

// Throws Error(usage) naming the table if bands or stops are missing, unsorted or not finite.
void check_colours(const ColourTable& table);

// Linear light in [0, 1] at a latitude (degrees) and height (metres).
std::array<float, 3> colour_at(const ColourTable& table, double latitude, double height);

}  // namespace carat
