// Colour tables: interpolation, sea level, the built-in data and what is refused.
#include <gtest/gtest.h>

#include <cmath>

#include "carat/globe/error.hpp"
#include "carat/vulkan/colour_table.hpp"
#include "carat/vulkan/picture.hpp"

namespace carat {

namespace {

ColourTable ramp() {
    return {"ramp",
            0.0,
            {{0, {{-100, {0, 0, 0}}, {0, {0, 0, 200}}}}},
            {{-10, {{0, {0, 0, 0}}, {100, {100, 0, 0}}}}, {10, {{0, {0, 0, 0}}, {100, {200, 0, 0}}}}}};
}

TEST(ColourTable, InterpolatesEncodedColours) {
    const auto red = [](double encoded) { return srgb_decode(static_cast<float>(encoded / 255)); };
    EXPECT_FLOAT_EQ(colour_at(ramp(), -10, 50)[0], red(50));
    EXPECT_FLOAT_EQ(colour_at(ramp(), 10, 50)[0], red(100));
    EXPECT_FLOAT_EQ(colour_at(ramp(), 0, 50)[0], red(75));
    EXPECT_FLOAT_EQ(colour_at(ramp(), 80, 25)[0], red(50)) << "constant beyond the last band";
    EXPECT_FLOAT_EQ(colour_at(ramp(), -10, 1e5)[0], red(100)) << "constant beyond the last stop";
}

// Latitudes are joined without a kink and without leaving the range of the two bands beside them.
TEST(ColourTable, IsSmoothAndMonotoneBetweenBands) {
    const auto stops = [](std::uint8_t v) { return std::vector<ColourStop>{{0, {v, v, v}}, {1, {v, v, v}}}; };
    const ColourTable table{
        "bands", std::nullopt, {}, {{-40, stops(10)}, {-10, stops(40)}, {20, stops(200)}, {50, stops(120)}}};
    const auto encoded = [&](double latitude) {
        return 255.0 * srgb_encode(colour_at(table, latitude, 0)[0]);
    };
    constexpr double kStep = 0.01;
    double slope_before = 0;
    for (double latitude = -60; latitude < 70; latitude += kStep) {
        const double slope = (encoded(latitude + kStep) - encoded(latitude)) / kStep;
        ASSERT_LT(std::abs(slope - slope_before), 0.05) << "kink at " << latitude;
        ASSERT_GE(slope, latitude < 20 - kStep ? -0.02 : -20) << latitude;
        ASSERT_LE(slope, latitude >= 20 ? 0.02 : 20) << latitude;
        slope_before = slope;
    }
    for (const auto& band : table.land) EXPECT_NEAR(encoded(band.latitude), band.stops[0].srgb[0], 0.01);
}

TEST(ColourTable, TheSeaReachesUpToItsLevel) {
    EXPECT_FLOAT_EQ(colour_at(ramp(), 0, 0)[2], srgb_decode(200.0f / 255));
    EXPECT_FLOAT_EQ(colour_at(ramp(), 0, -50)[2], srgb_decode(100.0f / 255));
    EXPECT_EQ(colour_at(ramp(), 0, 1e-9)[2], 0);
}

TEST(ColourTable, BuiltInTablesAreSound) {
    for (const char* body : {"earth", "moon", "mars", "", "pluto"})
        EXPECT_NO_THROW(check_colours(colours_of(body)));
    EXPECT_EQ(colours_of("mars").name, "mars");
    EXPECT_EQ(colours_of("pluto").name, "grey");
    const auto sea = colour_at(earth_colours(), 0, -4000), plain = colour_at(earth_colours(), 50, 100);
    EXPECT_GT(sea[2], 2 * sea[0]);
    EXPECT_GT(plain[1], plain[2]);
    const auto ice = colour_at(earth_colours(), -85, 3000);
    EXPECT_GT(ice[0], 0.8f);
}

TEST(ColourTable, RefusesWhatIsUnsorted) {
    const auto refused = [](auto change) {
        ColourTable table = ramp();
        change(table);
        try {
            check_colours(table);
            ADD_FAILURE() << "no error";
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), ErrorCode::usage);
            EXPECT_NE(std::string(e.what()).find("'ramp'"), std::string::npos);
        }
    };
    refused([](ColourTable& t) { t.land.clear(); });
    refused([](ColourTable& t) { t.sea.clear(); });
    refused([](ColourTable& t) { std::swap(t.land[0], t.land[1]); });
    refused([](ColourTable& t) { t.land[0].stops.resize(1); });
    refused([](ColourTable& t) { std::swap(t.land[0].stops[0], t.land[0].stops[1]); });
    refused([](ColourTable& t) { t.land[1].stops[0].height = std::numeric_limits<double>::quiet_NaN(); });
}

}  // namespace

}  // namespace carat
