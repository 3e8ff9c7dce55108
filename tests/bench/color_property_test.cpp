// Colour through YCoCg-R: the transform is reversible, and the tolerances of its components keep the RGB
// bound.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "carat/bench/color_bench.hpp"
#include "carat/bench/svg.hpp"

namespace carat::bench {
namespace {

using Pixel = std::array<std::int16_t, 3>;

TEST(YCoCg, IsReversibleForEveryColour) {
    for (int r = 0; r < 256; ++r)
        for (int g = 0; g < 256; ++g)
            for (int b = 0; b < 256; ++b) {
                const Pixel p{static_cast<std::int16_t>(r), static_cast<std::int16_t>(g),
                              static_cast<std::int16_t>(b)};
                ASSERT_EQ(rgb_of_ycocg(ycocg_of_rgb(p)), p);
            }
}

// Greatest error of a channel for errors of the components up to the tolerances, tried exhaustively.
int worst_error(const ComponentTolerances& t) {
    int worst = 0;
    for (const Pixel p : {Pixel{0, 0, 0}, Pixel{255, 254, 13}, Pixel{77, 200, 131}, Pixel{201, 8, 90}}) {
        const Pixel c = ycocg_of_rgb(p);
        for (int y = -t.y; y <= t.y; ++y)
            for (int co = -t.co; co <= t.co; ++co)
                for (int cg = -t.cg; cg <= t.cg; ++cg) {
                    const Pixel q = rgb_of_ycocg({static_cast<std::int16_t>(c[0] + y),
                                                  static_cast<std::int16_t>(c[1] + co),
                                                  static_cast<std::int16_t>(c[2] + cg)});
                    for (std::size_t k = 0; k < 3; ++k) worst = std::max(worst, std::abs(q[k] - p[k]));
                }
    }
    return worst;
}

TEST(YCoCg, ComponentTolerancesKeepTheBoundAndWasteNothing) {
    for (const int e : {0, 1, 2, 5, 10})
        for (const ComponentTolerances& t : component_tolerances(e))
            EXPECT_EQ(worst_error(t), e) << t.y << t.co << t.cg;
}

TEST(ColorBench, EveryRowKeepsTheTolerance) {
    Rgb image;
    std::uint32_t noise = 7;
    for (std::size_t c = 0; c < 3; ++c) {
        image[c].width = 150;
        image[c].height = 90;
        image[c].integer = true;
        for (int k = 0; k < 150 * 90; ++k) {
            noise = noise * 1664525u + 1013904223u;
            const double wave =
                std::sin((k % 150) * 0.05 + static_cast<double>(c)) * std::cos((k / 150) * 0.08);
            image[c].whole.push_back(
                static_cast<std::int16_t>(127 + 110 * wave + static_cast<double>(noise >> 29)));
        }
    }
    ColorOptions options;
    for (const int tolerance : {0, 4}) {
        options.tolerance = tolerance;
        const std::vector<ColorRow> rows = bench_color(image, options);
        EXPECT_EQ(rows.size(), 5u);
        for (const ColorRow& r : rows)
            EXPECT_TRUE(r.max_error <= tolerance || (r.codec == "jxl lossy e7" && tolerance == 0)) << r.codec;
    }
}

TEST(Svg, IsWellFormedAndEscapesNames) {
    const std::string svg =
        svg_of({{"a<b", "x & y", "z", {{"one", {0.5, 1, 4}, {1, 2, 3}, true}, {"none", {}, {}}}}});
    EXPECT_NE(svg.find("a&lt;b"), std::string::npos);
    EXPECT_NE(svg.find("x &amp; y"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.rfind("</svg>\n"), svg.size() - 7);
}

}  // namespace
}  // namespace carat::bench
