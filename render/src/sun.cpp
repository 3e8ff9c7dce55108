#include "carat/render/sun.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "carat/globe/error.hpp"

namespace carat {
namespace {

constexpr double kRadian = std::numbers::pi / 180;
constexpr double kJ2000 = 2451545;
constexpr double kTerrestrialMinusUtc = 69.184 / 86400;  // days, since 2017

double sin_deg(double x) { return std::sin(x * kRadian); }
double cos_deg(double x) { return std::cos(x * kRadian); }

// In [-180, 180).
double wrapped(double degrees) { return degrees - 360 * std::floor((degrees + 180) / 360); }

bool leap(int year) { return year % 4 == 0 && (year % 100 != 0 || year % 400 == 0); }

int days_of(int year, int month) {
    constexpr std::array days{31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    return days[static_cast<std::size_t>(month - 1)] + (month == 2 && leap(year) ? 1 : 0);
}

[[noreturn]] void refuse(const std::string& text) {
    throw Error(ErrorCode::usage,
                "\"" + text + "\" is no time: YYYY-MM-DDThh:mm:ssZ, UTC, years 1600 to 2600");
}

// Meeus, chapters 25 and 12. What nutation adds to right ascension and to sidereal time is the same.
Geodetic over_earth(double jd) {
    const double t = (jd + kTerrestrialMinusUtc - kJ2000) / 36525;
    const double mean_longitude = 280.46646 + t * (36000.76983 + t * 0.0003032);
    const double anomaly = 357.52911 + t * (35999.05029 - t * 0.0001537);
    const double centre = (1.914602 - t * (0.004817 + t * 0.000014)) * sin_deg(anomaly) +
                          (0.019993 - t * 0.000101) * sin_deg(2 * anomaly) + 0.000289 * sin_deg(3 * anomaly);
    const double node = 125.04 - 1934.136 * t;
    const double longitude = mean_longitude + centre - 0.00569 - 0.00478 * sin_deg(node);
    const double obliquity =
        23.4392911 - t * (0.0130042 + t * (0.00000016 - t * 0.000000504)) + 0.00256 * cos_deg(node);
    const double ascension =
        std::atan2(cos_deg(obliquity) * sin_deg(longitude), cos_deg(longitude)) / kRadian;
    const double declination = std::asin(sin_deg(obliquity) * sin_deg(longitude)) / kRadian;
    const double days = jd - kJ2000, c = days / 36525;
    const double sidereal = 280.46061837 + 360.98564736629 * days + c * c * (0.000387933 - c / 38710000) -
                            0.00478 * sin_deg(node) * cos_deg(obliquity);
    return {declination, wrapped(ascension - sidereal)};
}

// Allison and McEwen, equations 15 to 20 and 23 of the summary on the pages of Mars24.
Geodetic over_mars(double jd) {
    struct Term {
        double amplitude, years, phase;
    };
    constexpr std::array<Term, 7> perturbations{{{0.0071, 2.2353, 49.409},
                                                 {0.0057, 2.7543, 168.173},
                                                 {0.0039, 1.1177, 191.837},
                                                 {0.0037, 15.7866, 21.736},
                                                 {0.0021, 2.1354, 15.704},
                                                 {0.0020, 2.4694, 95.528},
                                                 {0.0018, 32.8493, 49.095}}};
    const double tt = jd + kTerrestrialMinusUtc, days = tt - kJ2000;
    const double anomaly = 19.3871 + 0.52402073 * days;
    const double mean_sun = 270.3871 + 0.524038496 * days;
    double centre = (10.691 + 3.0e-7 * days) * sin_deg(anomaly) + 0.623 * sin_deg(2 * anomaly) +
                    0.050 * sin_deg(3 * anomaly) + 0.005 * sin_deg(4 * anomaly) +
                    0.0005 * sin_deg(5 * anomaly);
    for (const Term& p : perturbations) centre += p.amplitude * cos_deg(0.985626 * days / p.years + p.phase);
    const double season = mean_sun + centre;  // areocentric solar longitude Ls
    const double equation_of_time =
        2.861 * sin_deg(2 * season) - 0.071 * sin_deg(4 * season) + 0.002 * sin_deg(6 * season) - centre;
    const double sols = (tt - 2451549.5) / 1.0274912517 + 44796.0 - 0.0009626;
    const double west = 360 * (sols - std::floor(sols)) + equation_of_time + 180;
    const double declination = std::asin(0.42565 * sin_deg(season)) / kRadian + 0.25 * sin_deg(season);
    return {declination, wrapped(-west)};
}

}  // namespace

double julian_date(const std::string& utc) {
    int year = 0, month = 0, day = 0, hour = 0, minute = 0, used = 0;
    if (std::sscanf(utc.c_str(), "%4d-%2d-%2dT%2d:%2d%n", &year, &month, &day, &hour, &minute, &used) != 5)
        refuse(utc);
    double second = 0;
    int more = 0;
    if (std::sscanf(utc.c_str() + used, ":%9lf%n", &second, &more) == 1) used += more;
    const std::string rest = utc.substr(static_cast<std::size_t>(used));
    if (!(rest.empty() || rest == "Z") || year < 1600 || year > 2600 || month < 1 || month > 12 || day < 1 ||
        day > days_of(year, month) || hour < 0 || hour > 23 || minute < 0 || minute > 59 ||
        !(second >= 0 && second < 61))
        refuse(utc);
    const int y = month > 2 ? year : year - 1, m = month > 2 ? month : month + 12;  // Meeus, chapter 7
    const int century = y / 100, gregorian = 2 - century + century / 4;
    const double midnight =
        std::floor(365.25 * (y + 4716)) + std::floor(30.6001 * (m + 1)) + day + gregorian - 1524.5;
    return midnight + (hour + (minute + second / 60) / 60) / 24;
}

Geodetic subsolar_point(const std::string& body, double julian_date_utc) {
    if (body == "earth") return over_earth(julian_date_utc);
    if (body == "mars") return over_mars(julian_date_utc);
    throw Error(ErrorCode::usage,
                "where the sun stands at a time is known for earth and mars, not for \"" + body + "\"");
}

}  // namespace carat
