#include "points.hpp"

#include <charconv>
#include <cmath>
#include <istream>
#include <string_view>

#include "carat/globe/error.hpp"

namespace carat::cli {
namespace {

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlank = " \t\r";
    const auto first = text.find_first_not_of(kBlank);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

// NaN unless the whole text is a number.
double number_in(std::string_view text) {
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() ? value : std::nan("");
}

bool is_heading(std::string_view text) { return text == "lat,lon" || text == "latitude,longitude"; }

}  // namespace

Point make_point(const std::string& latitude, const std::string& longitude, const std::string& where) {
    const double lat = number_in(trimmed(latitude)), lon = number_in(trimmed(longitude));
    if (!(std::abs(lat) <= 90))
        throw Error(ErrorCode::usage,
                    where + ": \"" + latitude + "\" is not a latitude in [-90, 90] degrees");
    if (!(std::abs(lon) <= 360))
        throw Error(ErrorCode::usage,
                    where + ": \"" + longitude + "\" is not a longitude in [-360, 360] degrees");
    return {{lat, lon}, std::string(trimmed(latitude)) + "," + std::string(trimmed(longitude))};
}

std::vector<Point> PointReader::next(std::size_t count) {
    std::vector<Point> points;
    std::string buffer;
    while (points.size() < count && std::getline(in_, buffer)) {
        ++line_;
        const std::string_view line = trimmed(buffer);
        if (line.empty() || line.front() == '#' || (line_ == 1 && is_heading(line))) continue;
        const std::string where = name_ + ": line " + std::to_string(line_);
        const auto comma = line.find(',');
        if (comma == std::string_view::npos || line.find(',', comma + 1) != std::string_view::npos)
            throw Error(ErrorCode::usage, where + ": \"" + std::string(line) + "\" is not \"lat,lon\"");
        points.push_back(
            make_point(std::string(line.substr(0, comma)), std::string(line.substr(comma + 1)), where));
    }
    if (in_.bad()) throw Error(ErrorCode::io, name_ + ": cannot be read");
    return points;
}

}  // namespace carat::cli
