// Where the sun stands over a turning body at a time.
//
//   Earth  J. Meeus, Astronomical Algorithms, 2nd ed. 1998, chapter 25 (low accuracy, 0.01 degrees from 1900
//          to 2100) and chapter 12 (sidereal time)
//   Mars   M. Allison and M. McEwen, A post-Pathfinder evaluation of areocentric solar coordinates, Planetary
//          and Space Science 48 (2000), as NASA's Mars24 uses it; 0.05 degrees from 1990 to 2050 with the
//          constant difference between UTC and terrestrial time that is used here
#pragma once

#include <string>

#include "carat/globe/ellipsoid.hpp"

namespace carat {

// Julian date, UTC, of "YYYY-MM-DDThh:mm[:ss[.s]]" with an optional Z at the end; the Gregorian calendar of
// the years 1600 to 2600. Throws Error(usage) for any other text.
double julian_date(const std::string& utc);

// The place whose zenith the sun passes at a time: declination and longitude, degrees. Throws Error(usage)
// for bodies other than "earth" and "mars".
Geodetic subsolar_point(const std::string& body, double julian_date_utc);

}  // namespace carat
