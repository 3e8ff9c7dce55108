// Paths as JSON text, and those that Carat ships.
//
// A path is a list of keyframes, or {"name": TEXT, "place": [LAT, LON], "keyframes": LIST}. A keyframe has
//
//   "time"             seconds, ascending
//   "lat", "lon"       degrees; or, round the place, "north", "east": degrees of latitude and longitude from
//   it "height"           metres above the ellipsoid; or "above": metres above the ground at the place; or
//                      "over": the same, and speed and descent go by it instead of by the height
//   "heading", "pitch", "fov"   degrees; default 0, -90, 45
//
// A path round a place can be flown elsewhere. No files but the path's own, no GPU; thread-safe.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "carat/render/flight.hpp"

namespace carat {

struct FlightPath {
    std::string name;  // as the path says, else its source
    std::vector<Keyframe> keyframes;
};

// Where a path round a place is flown, and on what.
struct FlightSite {
    std::optional<Geodetic> place;                  // instead of the path's own
    std::function<double(const Geodetic&)> ground;  // metres above the ellipsoid; empty: 0 everywhere
};

// Throws Error(corrupt), beginning with `source`, for text that is no path, and Error(usage) for a site's
// place where the path has none of its own.
FlightPath parse_flight_path(const std::string& json, const std::string& source, const FlightSite& site = {});

// `path`: a file, or else the name of a shipped path. Throws Error(io) if it is neither, and as above.
FlightPath read_flight_path(const std::string& path, const FlightSite& site = {});

// "orbit-to-ground": down from 20,000 km to a summit; "mountain-skim": 170 km at 30,000 km/h, low over peaks;
// "jumps-and-turns": full turns, and jumps between the summit, its country and another continent;
// "down-to-eye-level": from orbit to 1.7 m above the ground. Their place is Mount Whitney, California.
std::vector<std::string> shipped_flight_paths();

}  // namespace carat
