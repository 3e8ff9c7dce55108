// Places as lines of CSV.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include "carat/globe/ellipsoid.hpp"

namespace carat::cli {

// Places and how they were written.
struct Points {
    std::vector<Geodetic> places;     // degrees
    std::vector<std::uint32_t> ends;  // of each place in text
    std::string text;                 // "lat,lon" of all, one after the other

    std::size_t size() const { return places.size(); }
    std::string_view written(std::size_t k) const;
    // Latitude in [-90, 90], longitude in [-360, 360]. Throws Error(usage) that begins with where().
    using Where = std::function<std::string()>;
    void add(std::string_view latitude, std::string_view longitude, const Where& where);
};

// Reads "lat,lon" lines, in pieces. Blank lines, lines that begin with # and a first line "lat,lon" are
// skipped.
class PointReader {
  public:
    // name: of the stream, for messages.
    PointReader(std::istream& in, std::string name) : in_(in), name_(std::move(name)) {}

    // Up to `count` further points; none at the end. Throws Error(usage) naming a line that is not a place,
    // Error(io) if reading fails.
    Points next(std::size_t count);

  private:
    std::istream& in_;
    std::string name_;
    std::uint64_t line_ = 0;
};

}  // namespace carat::cli
