// Every raster of every kind holds, at the centre of each pixel, its own truth.
#include <gtest/gtest.h>

#include <cmath>

#include "carat/synth/synth.hpp"
#include "raster_reader.hpp"

namespace carat::synth {
namespace {

using test::Directory;
using test::Locator;
using test::Raster;

/// Rows and columns looked at: all when there are few, else a spread that includes both ends.
std::vector<int> picks(int count) {
    std::vector<int> result;
    const int step = std::max(1, count / 97);
    for (int i = 0; i < count; i += step) result.push_back(i);
    result.push_back(count - 1);
    return result;
}

/// Checks a file against its truth; returns how many samples were compared.
int check(const std::filesystem::path& path, const Written& f) {
    const auto raster = test::read_raster(path);
    EXPECT_TRUE(raster.has_value()) << f.name;
    if (!raster) return 0;
    EXPECT_EQ(raster->width, f.width) << f.name;
    EXPECT_EQ(raster->height, f.height) << f.name;
    EXPECT_EQ(raster->nodata, f.nodata) << f.name;
    EXPECT_EQ(raster->type, f.type == SampleType::int16 ? GDT_Int16 : GDT_Float32) << f.name;
    const Locator locator(*raster);
    // The normal of a pixel is known to some 1e-15 here and there; steep truth turns that into below a
    // millimetre.
    const double rounding = f.type == SampleType::int16 ? 0.5 : 0;
    int compared = 0, wrong = 0;
    for (const int r : picks(raster->height))
        for (const int c : picks(raster->width)) {
            const double sample = raster->at(c, r), truth = f.truth(locator.normal(c, r));
            ++compared;
            if (std::isnan(truth))
                wrong += f.nodata ? sample != *f.nodata : !std::isnan(sample);
            else if (std::isinf(truth))
                wrong += sample != truth;
            else
                wrong += !(std::abs(sample - truth) <= rounding + 1e-3 + 1e-7 * std::abs(truth));
        }
    EXPECT_EQ(wrong, 0) << f.name << ": of " << compared;
    return compared;
}

class RasterAccuracy : public testing::TestWithParam<Kind> {};

TEST_P(RasterAccuracy, EverySampleIsTheTruthAtItsPixelCentre) {
    const Directory directory("synth_accuracy");
    Options options;
    options.size = 360;
    options.inset_size = 300;
    options.seed = 3;
    int compared = 0;
    for (const Written& f : write(GetParam(), directory.path(), options))
        if (f.readable) compared += check(directory.path() / f.name, f);
    EXPECT_GT(compared, 0);
}

TEST_P(RasterAccuracy, PlanetIsTheTruthOfTheFirstFile) {
    if (GetParam() == Kind::earth || GetParam() == Kind::moon || GetParam() == Kind::hostile) return;
    const Directory directory("synth_planet");
    const Options options;
    const std::vector<Written> files = write(GetParam(), directory.path(), options);
    const Planet p = planet(GetParam(), options);
    for (int i = 0; i < 100; ++i) {
        const double z = std::sin(i * 0.3), r = std::sqrt(1 - z * z);
        const std::array<double, 3> n{r * std::cos(i), r * std::sin(i), z};
        const double a = p.height(n), b = files.front().truth(n);
        EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b)));
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, RasterAccuracy,
                         testing::Values(Kind::earth, Kind::moon, Kind::spikes, Kind::cliff,
                                         Kind::checkerboard, Kind::constant, Kind::nodata, Kind::nonfinite,
                                         Kind::int16, Kind::onepixel, Kind::overlap, Kind::antimeridian,
                                         Kind::polar, Kind::rotated),
                         [](const auto& p) {
                             return std::string(kinds()[static_cast<std::size_t>(p.param)].name);
                         });

TEST(RasterAccuracyInt16, EarthRoundsToWholeMetres) {
    const Directory directory("synth_int16");
    Options options;
    options.size = 360;
    options.inset_size = 300;
    options.type = SampleType::int16;
    for (const Written& f : write(Kind::moon, directory.path(), options)) {
        EXPECT_EQ(f.type, SampleType::int16);
        check(directory.path() / f.name, f);
    }
}

TEST(RasterAccuracyPlanet, FinestWavelengthIsWhatOptionsSay) {
    Options options;
    options.min_wavelength_m = 5000;
    const Planet earth = planet(Kind::earth, options), moon = planet(Kind::moon, options);
    const std::array<double, 3> n{0.48, -0.6, 0.64};
    EXPECT_EQ(earth.height(n), earthlike_height(n, 1, 5000));
    EXPECT_EQ(moon.height(n), moonlike_height(n, 1, 5000));
    EXPECT_EQ(earth.body, Ellipsoid::earth());
    EXPECT_EQ(moon.body, Ellipsoid::moon());
}

}  // namespace
}  // namespace carat::synth
