// Places as lines of CSV.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "carat/globe/ellipsoid.hpp"

namespace carat::cli {

struct Point {
    Geodetic place;    // degrees
    std::string text;  // "lat,lon" as it was given
};

// Latitude in [-90, 90], longitude in [-360, 360]. Throws Error(usage) that begins with `where`.
Point make_point(const std::string& latitude, const std::string& longitude, const std::string& where);

// Reads "lat,lon" lines, in pieces. Blank lines, lines that begin with # and a first line "lat,lon" are
// skipped.
class PointReader {
  public:
    // name: of the stream, for messages.
    PointReader(std::istream& in, std::string name) : in_(in), name_(std::move(name)) {}

    // Up to `count` further points; none at the end. Throws Error(usage) naming a line that is not a place,
    // Error(io) if reading fails.
    std::vector<Point> next(std::size_t count);

  private:
    std::istream& in_;
    std::string name_;
    std::uint64_t line_ = 0;
};

}  // namespace carat::cli
