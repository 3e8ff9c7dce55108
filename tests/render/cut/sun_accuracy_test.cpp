// The subsolar point against worked examples and dates that are published.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "carat/globe/error.hpp"
#include "carat/render/sun.hpp"

namespace carat {
namespace {

double between(double a, double b) { return std::abs(std::remainder(a - b, 360)); }

TEST(Sun, JulianDates) {
    EXPECT_DOUBLE_EQ(julian_date("2000-01-01T12:00:00Z"), 2451545.0);
    EXPECT_DOUBLE_EQ(julian_date("1987-01-27T00:00"), 2446822.5);  // Meeus, chapter 7
    EXPECT_DOUBLE_EQ(julian_date("1600-12-31T00:00"), 2305812.5);
    EXPECT_NEAR(julian_date("1987-04-10T19:21:00.0Z"), 2446896.30625, 1e-8);
    EXPECT_DOUBLE_EQ(julian_date("2024-02-29T00:00"), julian_date("2024-03-01T00:00") - 1);
}

TEST(Sun, TimesThatAreNoneAreRefused) {
    for (const char* text :
         {"", "now", "2024-06-21", "2023-02-29T00:00", "2024-13-01T00:00", "2024-06-21T24:00",
          "2024-06-21T12:60", "2024-06-21T12:00:00+02", "1599-01-01T00:00", "2024-06-21T12:00:99"}) {
        SCOPED_TRACE(text);
        try {
            julian_date(text);
            ADD_FAILURE() << "no error";
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), ErrorCode::usage);
        }
    }
}

// Meeus, example 25.a: 1992 October 13.0 TD: declination -7.78507, right ascension 198.38083 degrees. The
// longitude follows from the sidereal time of that moment by the IAU 1982 formula, by hand: 21.80117.
TEST(Sun, WorkedExampleOfTheEarth) {
    const Geodetic p = subsolar_point("earth", 2448908.5 - 69.184 / 86400);
    EXPECT_NEAR(p.latitude, -7.78507, 1e-4);
    const double t = (2448908.5 - 69.184 / 86400 - 2451545) / 36525;
    const double seconds = 67310.54841 + t * (876600.0 * 3600 + 8640184.812866 + t * (0.093104 - t * 6.2e-6));
    EXPECT_LT(between(p.longitude, 198.38083 - seconds / 240), 0.006);  // nutation apart
}

// Equinoxes and solstices of 2024, USNO: to the minute. The obliquity of that year: 23.4361 degrees, 9" of
// nutation.
TEST(Sun, SeasonsOf2024) {
    EXPECT_NEAR(subsolar_point("earth", julian_date("2024-03-20T03:06")).latitude, 0, 0.01);
    EXPECT_NEAR(subsolar_point("earth", julian_date("2024-09-22T12:44")).latitude, 0, 0.01);
    EXPECT_NEAR(subsolar_point("earth", julian_date("2024-06-20T20:51")).latitude, 23.4386, 0.001);
    EXPECT_NEAR(subsolar_point("earth", julian_date("2024-12-21T09:20")).latitude, -23.4386, 0.001);
}

// On 16 April, 14 June, 1 September and 25 December the equation of time is 0 within half a minute: the sun
// stands over Greenwich at noon. On 3 November it is 16.4 minutes ahead, on 11 February 14.2 behind.
TEST(Sun, EquationOfTime) {
    for (const char* date : {"2023-04-15T12:00", "2023-06-13T12:00", "2023-09-01T12:00", "2023-12-25T12:00"})
        EXPECT_NEAR(subsolar_point("earth", julian_date(date)).longitude, 0, 0.13) << date;
    EXPECT_NEAR(subsolar_point("earth", julian_date("2023-11-03T12:00")).longitude, -16.45 / 4, 0.03);
    EXPECT_NEAR(subsolar_point("earth", julian_date("2023-02-11T12:00")).longitude, 14.23 / 4, 0.03);
    EXPECT_NEAR(subsolar_point("earth", julian_date("2023-06-13T18:00")).longitude, -90, 0.13);
}

// The example of Mars24 for 2000-01-06 00:00 UTC: subsolar longitude 174.72398 west, solar longitude
// 277.18758: a declination of -25.228 degrees. The constant difference to terrestrial time moves Mars by 0.02
// degrees.
TEST(Sun, WorkedExampleOfMars) {
    const Geodetic p = subsolar_point("mars", 2451549.5);
    EXPECT_LT(between(p.longitude, -174.72398), 0.03);
    EXPECT_NEAR(p.latitude, -25.23, 0.01);
    // A sol later the sun stands there again, but for the equation of time.
    EXPECT_LT(between(subsolar_point("mars", 2451549.5 + 1.0274912517).longitude, p.longitude), 0.3);
}

TEST(Sun, OtherBodiesAreRefused) {
    try {
        subsolar_point("moon", 2451545);
        ADD_FAILURE() << "no error";
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::usage);
        EXPECT_NE(std::string(e.what()).find("moon"), std::string::npos);
    }
}

}  // namespace
}  // namespace carat
