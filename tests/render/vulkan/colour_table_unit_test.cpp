// Colour tables: interpolation, sea level, the built-in data and what is refused.
#include <gtest/gtest.h>

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
