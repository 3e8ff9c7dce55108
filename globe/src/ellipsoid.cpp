#include "carat/globe/ellipsoid.hpp"

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/Math.hpp>
#include <charconv>
#include <cmath>
#include <vector>

#include "carat/globe/error.hpp"
#include "derivative.hpp"

namespace carat {
namespace {

// Within these, squares neither overflow nor vanish and the derivative bounds are true (tests/globe).
constexpr double kLeastAxis = 1e-3, kGreatestAxis = 1e12;
constexpr double kMostOblate = 10;

}  // namespace

Vec3 direction(const Geodetic& g) {
    if (!std::isfinite(g.latitude) || std::abs(g.latitude) > 90 || !std::isfinite(g.longitude))
        throw Error(ErrorCode::usage, "latitude " + std::to_string(g.latitude) + ", longitude " +
                                          std::to_string(g.longitude) + " is not a place: |latitude| <= 90");
    double sin_lat = 0, cos_lat = 0, sin_lon = 0, cos_lon = 0;
    GeographicLib::Math::sincosd(g.latitude, sin_lat, cos_lat);
    GeographicLib::Math::sincosd(g.longitude, sin_lon, cos_lon);
    // -180 and 180 are one meridian and must be one vector: no negative zeros.
    return {cos_lat * cos_lon + 0.0, cos_lat * sin_lon + 0.0, sin_lat + 0.0};
}

Geodetic geodetic(const Vec3& n) {
    const double across = std::hypot(n[0], n[1]);
    return {GeographicLib::Math::atan2d(n[2], across),
            across == 0 ? 0.0 : GeographicLib::Math::atan2d(n[1] + 0.0, n[0])};
}

Ellipsoid::Ellipsoid(double equatorial, double polar, std::string name)
    : a_(equatorial), b_(polar), name_(std::move(name)) {
    // Negated, so that NaN is refused.
    if (!(b_ <= a_ && b_ >= a_ / kMostOblate && a_ >= kLeastAxis && a_ <= kGreatestAxis))
        throw Error(ErrorCode::usage,
                    "semi-axes " + std::to_string(a_) + ", " + std::to_string(b_) +
                        " m are not an oblate ellipsoid: equatorial / 10 <= polar <= equatorial, "
                        "1 mm <= equatorial <= 1e12 m");
    const DerivativeBounds d = derivative_bounds(*this);
    d2_ = d.second;
    d3_ = d.third;
}

Ellipsoid Ellipsoid::earth() { return {6378137.0, 6378137.0 * (1 - 1 / 298.257223563), "earth"}; }
Ellipsoid Ellipsoid::moon() { return {1737400.0, 1737400.0, "moon"}; }
Ellipsoid Ellipsoid::mars() { return {3396190.0, 3376200.0, "mars"}; }

Ellipsoid Ellipsoid::parse(const std::string& text) {
    if (text == "earth") return earth();
    if (text == "moon") return moon();
    if (text == "mars") return mars();
    const char* const end = text.data() + text.size();
    double a = 0, b = 0;
    const auto first = std::from_chars(text.data(), end, a);
    if (first.ec == std::errc{} && first.ptr != end && *first.ptr == ',') {
        const auto second = std::from_chars(first.ptr + 1, end, b);
        if (second.ec == std::errc{} && second.ptr == end) return {a, b};
    }
    throw Error(ErrorCode::usage,
                "body '" + text + "' is not earth, moon, mars or A,B (semi-axes in metres)");
}

Vec3 Ellipsoid::position(const Vec3& n, double h) const {
    const double a2 = a_ * a_, b2 = b_ * b_;
    const double ex = a2 * n[0], ey = a2 * n[1], ez = b2 * n[2];
    const double length = std::sqrt(ex * n[0] + ey * n[1] + ez * n[2]);
    return {ex / length + h * n[0], ey / length + h * n[1], ez / length + h * n[2]};
}

Ellipsoid::NormalHeight Ellipsoid::normal_height(const Vec3& p) const {
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
        throw Error(ErrorCode::usage, "position is not finite");
    const GeographicLib::Geocentric earth(a_, (a_ - b_) / a_);
    double lat = 0, lon = 0, h = 0;
    std::vector<double> rotation(9);
    earth.Reverse(p[0], p[1], p[2], lat, lon, h, rotation);
    // Columns of the rotation are east, north, up: up is the normal, free of a round trip through degrees.
    return {{rotation[2], rotation[5], rotation[8]}, h};
}

}  // namespace carat
