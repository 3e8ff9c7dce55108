// Paths of keyframes: where the eye is, how fast it goes, and the JSON that says so.
#include <gtest/gtest.h>

#include <GeographicLib/Geodesic.hpp>
#include <cmath>

#include "carat/globe/error.hpp"
#include "carat/render/flight_path.hpp"

namespace carat::test {
namespace {

Keyframe key(double time, double latitude, double longitude, double height, double heading = 0) {
    Keyframe k;
    k.time = time;
    k.eye = {latitude, longitude};
    k.height = height;
    k.heading = heading;
    return k;
}

double distance(const Geodetic& from, const Geodetic& to) {
    double metres = 0;
    GeographicLib::Geodesic::WGS84().Inverse(from.latitude, from.longitude, to.latitude, to.longitude,
                                             metres);
    return metres;
}

TEST(Flight, PassesThroughItsKeyframes) {
    const std::vector<Keyframe> keys{key(2, 10, 170, 1e6, 350), key(12, -20, -175, 2e3, 20),
                                     key(22, -20, -174, 2e3, 90)};
    const Flight flight(Ellipsoid::earth(), keys);
    EXPECT_EQ(flight.duration(), 20);
    for (const Keyframe& k : keys) {
        const ViewRequest at = flight.at(k.time - 2);
        EXPECT_LT(distance(at.eye, k.eye), 1e-3);
        EXPECT_NEAR(at.height, k.height, 1e-6 * k.height);
        EXPECT_NEAR(std::remainder(at.heading - k.heading, 360), 0, 1e-9);
    }
    const ViewRequest before = flight.at(-5), after = flight.at(1000);
    EXPECT_LT(distance(before.eye, keys.front().eye), 1e-3);
    EXPECT_LT(distance(after.eye, keys.back().eye), 1e-3);
}

TEST(Flight, FollowsTheGeodesicAcrossTheAntimeridian) {
    const Geodetic from{10, 170}, to{-20, -175};
    const Flight flight(Ellipsoid::earth(), {key(0, 10, 170, 1e5), key(10, -20, -175, 1e5)});
    const double whole = distance(from, to);
    for (int k = 0; k <= 50; ++k) {
        const Geodetic at = flight.at(0.2 * k).eye;
        EXPECT_NEAR(distance(from, at) + distance(at, to), whole, 1e-2) << k;
    }
}

// Eased ends apart, speed over ground is in proportion to height, and height falls by equal factors.
TEST(Flight, SpeedIsInProportionToHeight) {
    const Flight flight(Ellipsoid::earth(), {key(0, 0, 0, 1e6), key(40, 30, 0, 1e3)});
    constexpr double kStep = 0.01;
    const auto speed_by_height = [&](double t) {
        const ViewRequest a = flight.at(t), b = flight.at(t + kStep);
        return distance(a.eye, b.eye) / kStep / std::sqrt(a.height * b.height);
    };
    const double early = speed_by_height(5), fall = flight.at(5).height / flight.at(6).height;
    EXPECT_GT(early, 0);
    for (double t = 6; t < 36; t += 3) {
        EXPECT_NEAR(speed_by_height(t) / early, 1, 1e-3) << t;
        EXPECT_NEAR(flight.at(t).height / flight.at(t + 1).height, fall, 1e-6) << t;
    }
}

TEST(Flight, StartsAndEndsAtRest) {
    const Flight flight(Ellipsoid::earth(), {key(0, 0, 0, 1e4), key(40, 1, 0, 1e4)});
    const double cruise = distance(flight.at(20).eye, flight.at(20.01).eye);
    EXPECT_LT(distance(flight.at(0).eye, flight.at(0.01).eye), 0.02 * cruise);
    EXPECT_LT(distance(flight.at(39.99).eye, flight.at(40).eye), 0.02 * cruise);
}

TEST(Flight, HeadingTurnsTheShorterWay) {
    const Flight flight(Ellipsoid::earth(), {key(0, 0, 0, 1e4, 350), key(10, 0, 1, 1e4, 20)});
    for (int k = 0; k <= 100; ++k) {
        const double turned = flight.at(0.1 * k).heading - 350;
        EXPECT_GE(turned, -1e-9);
        EXPECT_LE(turned, 30 + 1e-9);
    }
}

// Heading and pitch have no jerk at a keyframe, and do not swing beyond what two of them say.
TEST(Flight, TurnsSmoothlyAndNotBeyondItsKeyframes) {
    std::vector<Keyframe> keys;
    const double headings[] = {350, 20, 25, 110, 110, 80};
    for (int k = 0; k < 6; ++k) keys.push_back(key(4 * k, 0, k, 1e4, headings[k]));
    for (int k = 0; k < 6; ++k) keys[static_cast<std::size_t>(k)].roll = k % 2 == 0 ? -30 : 30;
    const Flight flight(Ellipsoid::earth(), keys);
    constexpr double kStep = 1e-4;
    const auto rate = [&](double t) { return (flight.at(t + kStep).heading - flight.at(t).heading) / kStep; };
    for (int k = 1; k < 5; ++k) EXPECT_NEAR(rate(4 * k - kStep), rate(4 * k), 0.01) << k;
    for (int k = 0; k < 5; ++k) {
        const double from = flight.at(4 * k).heading, to = flight.at(4 * k + 4).heading;
        for (double t = 4 * k; t <= 4 * k + 4; t += 0.05) {
            EXPECT_GE(flight.at(t).heading, std::min(from, to) - 1e-9) << t;
            EXPECT_LE(flight.at(t).heading, std::max(from, to) + 1e-9) << t;
            EXPECT_LE(std::abs(flight.at(t).roll), 30 + 1e-9);
        }
    }
    EXPECT_GT(rate(10), 5);  // linear between neighbours would be 21 there
}

TEST(Flight, PathsThatAreNoneAreRefused) {
    const Ellipsoid earth = Ellipsoid::earth();
    EXPECT_THROW(Flight(earth, {key(0, 0, 0, 1)}), Error);
    EXPECT_THROW(Flight(earth, {key(0, 0, 0, 1), key(0, 1, 1, 1)}), Error);
    EXPECT_THROW(Flight(earth, {key(0, 0, 0, 1), key(1, 91, 1, 1)}), Error);
    EXPECT_THROW(Flight(earth, {key(0, 0, 0, 0), key(1, 1, 1, 1)}), Error);
}

TEST(FlightPath, AListOfKeyframes) {
    const FlightPath path = parse_flight_path(
        R"([{"time": 1, "lat": 2, "lon": 3, "height": 4}, {"time": 5, "lat": -6, "lon": 7, "height": 8, "heading": 9, "pitch": 10, "fov": 11}])",
        "here");
    EXPECT_EQ(path.name, "here");
    ASSERT_EQ(path.keyframes.size(), 2u);
    EXPECT_EQ(path.keyframes[0].pitch, -90);
    EXPECT_EQ(path.keyframes[0].fov, 45);
    EXPECT_EQ(path.keyframes[1].eye.latitude, -6);
    EXPECT_EQ(path.keyframes[1].eye.longitude, 7);
    EXPECT_EQ(path.keyframes[1].heading, 9);
}

TEST(FlightPath, RoundAPlaceItFollowsTheSite) {
    const std::string text =
        R"({"name": "x", "place": [10, 20], "keyframes": [{"time": 0, "north": 1, "east": 2, "above": 100}]})";
    const Keyframe own = parse_flight_path(text, "here").keyframes.at(0);
    EXPECT_EQ(own.eye.latitude, 11);
    EXPECT_EQ(own.eye.longitude, 22);
    EXPECT_EQ(own.height, 100);
    Geodetic asked;
    const FlightSite site{Geodetic{-40, 179}, [&](const Geodetic& place) {
                              asked = place;
                              return 1500.0;
                          }};
    const Keyframe there = parse_flight_path(text, "here", site).keyframes.at(0);
    EXPECT_EQ(there.eye.latitude, -39);
    EXPECT_NEAR(there.eye.longitude, -179, 1e-12);
    EXPECT_EQ(there.height, 1600);
    EXPECT_EQ(asked.longitude, 179) << "the ground is that of the place, not of the keyframe";
}

ErrorCode refused(const std::string& text, const FlightSite& site = {}) {
    try {
        (void)parse_flight_path(text, "there", site);
    } catch (const Error& e) {
        EXPECT_EQ(std::string(e.what()).rfind("there: ", 0), 0u) << e.what();
        return e.code();
    }
    ADD_FAILURE() << "accepted: " << text;
    return ErrorCode::io;
}

TEST(FlightPath, WhatIsNoPathIsRefusedByName) {
    EXPECT_EQ(refused("[{]"), ErrorCode::corrupt);
    EXPECT_EQ(refused(R"([{"time": 0}])"), ErrorCode::corrupt);
    EXPECT_EQ(refused(R"([{"time": 0, "north": 1, "height": 5}])"), ErrorCode::corrupt);
    EXPECT_EQ(refused(R"({"place": [1], "keyframes": []})"), ErrorCode::corrupt);
    EXPECT_EQ(refused(R"([{"time": 0, "lat": 1, "lon": 1, "height": 5}])", {Geodetic{1, 2}, {}}),
              ErrorCode::usage);
    EXPECT_THROW((void)read_flight_path("no-such-path"), Error);
}

// Below sea level as elsewhere: each second the height above the base falls by the same factor.
TEST(Flight, FallsByEqualFactorsAboveItsBase) {
    Keyframe from = key(0, 10, 20, 1000), to = key(30, 10, 20, -198.3);
    to.base = from.base = -200;
    const Flight flight(Ellipsoid::earth(), {from, to});
    const auto over = [&](double t) { return flight.at(t).height + 200; };
    EXPECT_NEAR(over(30), 1.7, 1e-9);
    for (double t = 4; t < 26; t += 1) EXPECT_NEAR(over(t + 1) / over(t), over(5) / over(4), 1e-6) << t;
    to.height = -200;
    EXPECT_THROW(Flight(Ellipsoid::earth(), {from, to}), Error);
}

TEST(FlightPath, TheShippedOnesFlyOverAnyGround) {
    EXPECT_GE(shipped_flight_paths().size(), 3u);
    for (const std::string& name : shipped_flight_paths())
        for (const double ground : {-200.0, 0.0, 8000.0}) {
            const FlightPath path =
                read_flight_path(name, {Geodetic{-30, 170}, [&](const Geodetic&) { return ground; }});
            EXPECT_NE(path.name, name) << "they have names of their own";
            const Flight flight(Ellipsoid::earth(), path.keyframes);
            EXPECT_GE(flight.duration(), 10);
        }
}

}  // namespace
}  // namespace carat::test
