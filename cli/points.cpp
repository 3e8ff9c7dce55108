#include "points.hpp"

#include <fmt/format.h>

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

std::string_view Points::written(std::size_t k) const {
    const std::size_t begin = k == 0 ? 0 : ends[k - 1];
    return std::string_view(text).substr(begin, ends[k] - begin);
}

void Points::add(std::string_view latitude, std::string_view longitude, const Where& where) {
    latitude = trimmed(latitude);
    longitude = trimmed(longitude);
    const double lat = number_in(latitude), lon = number_in(longitude);
    if (!(std::abs(lat) <= 90))
        throw Error(ErrorCode::usage,
                    fmt::format("{}: \"{}\" is not a latitude in [-90, 90] degrees", where(), latitude));
    if (!(std::abs(lon) <= 360))
        throw Error(ErrorCode::usage,
                    fmt::format("{}: \"{}\" is not a longitude in [-360, 360] degrees", where(), longitude));
    places.push_back({lat, lon});
    text.append(latitude).append(1, ',').append(longitude);
    ends.push_back(static_cast<std::uint32_t>(text.size()));
}

Points PointReader::next(std::size_t count) {
    constexpr std::size_t kMostText = 1u << 30;  // ends are 32 bits
    Points points;
    std::string buffer;
    while (points.size() < count && points.text.size() < kMostText && std::getline(in_, buffer)) {
        ++line_;
        const std::string_view line = trimmed(buffer);
        if (line.empty() || line.front() == '#' || (line_ == 1 && is_heading(line))) continue;
        const auto where = [&] { return fmt::format("{}: line {}", name_, line_); };
        const auto comma = line.find(',');
        if (comma == std::string_view::npos || line.find(',', comma + 1) != std::string_view::npos)
            throw Error(ErrorCode::usage, fmt::format("{}: \"{}\" is not \"lat,lon\"", where(), line));
        points.add(line.substr(0, comma), line.substr(comma + 1), where);
    }
    if (in_.bad()) throw Error(ErrorCode::io, name_ + ": cannot be read");
    return points;
}

}  // namespace carat::cli
