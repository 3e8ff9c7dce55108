// Each hostile file has the property it is named for, seen through GDAL.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "carat/synth/synth.hpp"
#include "raster_reader.hpp"

namespace carat::synth {
namespace {

using test::Directory;
using test::Locator;
using test::Raster;

/// The files of one kind in a directory of their own.
class Hostile : public testing::Test {
  protected:
    Raster raster(Kind kind, const std::string& name) {
        make(kind);
        const auto r = test::read_raster(path(name));
        EXPECT_TRUE(r.has_value()) << name;
        return r.value_or(Raster{});
    }
    std::filesystem::path path(const std::string& name) const { return directory_.path() / name; }
    const Written& written(const std::string& name) const { return files_.at(name); }
    void make(Kind kind) {
        if (made_ == kind) return;
        Options options;
        options.overwrite = true;
        for (Written& f : write(kind, directory_.path(), options)) files_[f.name] = std::move(f);
        made_ = kind;
    }

  private:
    Directory directory_{"synth_hostile"};
    std::map<std::string, Written> files_;
    std::optional<Kind> made_;
};

TEST_F(Hostile, SpikesStandOnPolesAndAntimeridian) {
    const Raster r = raster(Kind::spikes, "spikes.tif");
    for (int c = 0; c < r.width; c += 90) {
        EXPECT_GT(r.at(c, 0), 6000);
        EXPECT_GT(r.at(c, r.height - 1), 6000);
    }
    const int equator = r.height / 2;
    EXPECT_GT(r.at(0, equator), 5000);
    EXPECT_GT(r.at(r.width - 1, equator), 5000);
    EXPECT_EQ(r.at(r.width / 2, equator), 0);
}

TEST_F(Hostile, CliffsFollowTheCubeEdges) {
    const Raster r = raster(Kind::cliff, "cliff.tif");
    const Locator locator(r);
    int crossings = 0, cliffs = 0;
    for (int row = 0; row < r.height; row += 7)
        for (int c = 0; c + 1 < r.width; ++c) {
            const auto face = [&](int column) {
                const auto n = locator.normal(column, row);
                const double x = std::abs(n[0]), y = std::abs(n[1]), z = std::abs(n[2]);
                return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
            };
            const bool crosses = face(c) != face(c + 1);
            const double jump = std::abs(r.at(c, row) - r.at(c + 1, row));
            crossings += crosses;
            cliffs += jump >= 10000;
            EXPECT_EQ(crosses, jump > 0);
        }
    EXPECT_EQ(crossings, cliffs);
    EXPECT_GT(crossings, 200);
}

TEST_F(Hostile, CheckerboardAlternates) {
    const Raster r = raster(Kind::checkerboard, "checkerboard.tif");
    for (int row = 0; row + 1 < r.height; ++row)
        for (int c = 0; c < r.width; ++c) {
            EXPECT_EQ(std::abs(r.at(c, row)), 1000);
            EXPECT_EQ(r.at(c, row), -r.at((c + 1) % r.width, row));
            EXPECT_EQ(r.at(c, row), -r.at(c, row + 1));
        }
}

TEST_F(Hostile, ConstantIsConstant) {
    for (const double h : raster(Kind::constant, "constant.tif").samples) EXPECT_EQ(h, 1234.5);
}

TEST_F(Hostile, NodataIsNothingElse) {
    const Raster r = raster(Kind::nodata, "nodata.tif");
    ASSERT_TRUE(r.nodata.has_value());
    for (const double h : r.samples) EXPECT_EQ(h, *r.nodata);
}

TEST_F(Hostile, NonfiniteHasNanAndInfinitiesAndNoNodata) {
    const Raster r = raster(Kind::nonfinite, "nonfinite.tif");
    EXPECT_FALSE(r.nodata.has_value());
    std::size_t nan = 0, up = 0, down = 0;
    for (const double h : r.samples) {
        nan += std::isnan(h);
        up += std::isinf(h) && h > 0;
        down += std::isinf(h) && h < 0;
    }
    EXPECT_NEAR(static_cast<double>(nan) / static_cast<double>(r.samples.size()), 0.02, 0.004);
    EXPECT_NEAR(static_cast<double>(up) / static_cast<double>(r.samples.size()), 0.01, 0.003);
    EXPECT_NEAR(static_cast<double>(down) / static_cast<double>(r.samples.size()), 0.01, 0.003);
}

TEST_F(Hostile, Int16ReachesBothEndsAndHasNoNodata) {
    const Raster r = raster(Kind::int16, "int16.tif");
    EXPECT_EQ(r.type, GDT_Int16);
    EXPECT_FALSE(r.nodata.has_value());
    EXPECT_GT(std::count(r.samples.begin(), r.samples.end(), -32768), 5000);
    EXPECT_GT(std::count(r.samples.begin(), r.samples.end(), 32767), 5000);
}

TEST_F(Hostile, OnepixelHasOnePixel) {
    const Raster r = raster(Kind::onepixel, "onepixel.tif");
    EXPECT_EQ(r.width, 1);
    EXPECT_EQ(r.height, 1);
    EXPECT_EQ(r.at(0, 0), 777);
}

TEST_F(Hostile, OverlapsDisagreeByAHundredMetres) {
    const Raster a = raster(Kind::overlap, "overlap_a.tif"), b = raster(Kind::overlap, "overlap_b.tif"),
                 c = raster(Kind::overlap, "overlap_c.tif");
    EXPECT_EQ(a.transform[1], b.transform[1]);
    EXPECT_EQ(a.transform[1], c.transform[1]);
    // 15..20 E, 40..50 N is in a and b; 15..20 E, 40..45 N in all.
    for (int row = 0; row < 100; row += 9)
        for (int column = 100; column < 200; column += 9) {
            EXPECT_NEAR(b.at(column - 100, row) - a.at(column, row), 100, 0.01);
            EXPECT_NEAR(c.at(column - 50, row) - a.at(column, row + 100), 200, 0.01);
        }
}

TEST_F(Hostile, AntimeridianIsCrossed) {
    for (const char* name : {"antimeridian.tif", "antimeridian_utm.tif"}) {
        const Raster r = raster(Kind::antimeridian, name);
        const Locator locator(r);
        const auto y_of = [&](int column) { return locator.normal(column, r.height / 2)[1]; };
        EXPECT_GT(y_of(0), 0.01) << name;             // west of 180
        EXPECT_LT(y_of(r.width - 1), -0.01) << name;  // east of it
        EXPECT_LT(written(name).bounds.west, 180) << name;
        EXPECT_GT(written(name).bounds.east, 180) << name;
    }
}

TEST_F(Hostile, PolarRastersHoldTheirPole) {
    const Raster north = raster(Kind::polar, "polar_north.tif"),
                 south = raster(Kind::polar, "polar_south.tif");
    const double middle = north.width / 2.0 - 0.5;
    EXPECT_NEAR(Locator(north).normal(middle, middle)[2], 1, 1e-12);
    EXPECT_NEAR(Locator(south).normal(middle, middle)[2], -1, 1e-12);
    EXPECT_EQ(written("polar_north.tif").bounds.north, 90);
    EXPECT_EQ(written("polar_south.tif").bounds.south, -90);
}

TEST_F(Hostile, RotatedIsRotated) {
    const Raster r = raster(Kind::rotated, "rotated.tif");
    EXPECT_NEAR(std::atan2(r.transform[4], r.transform[1]), std::acos(-1.0) / 6, 1e-9);
    EXPECT_NEAR(std::atan2(r.transform[2], -r.transform[5]), std::acos(-1.0) / 6, 1e-9);
}

TEST_F(Hostile, BrokenFilesCannotBeRead) {
    make(Kind::empty);
    make(Kind::truncated);
    EXPECT_EQ(std::filesystem::file_size(path("empty.tif")), 0U);
    EXPECT_EQ(std::filesystem::file_size(path("truncated_header.tif")), 100U);
    EXPECT_GT(std::filesystem::file_size(path("truncated_data.tif")), 10000U);
    for (const char* name : {"empty.tif", "truncated_header.tif", "truncated_data.tif"}) {
        EXPECT_FALSE(test::read_raster(path(name)).has_value()) << name;
        EXPECT_FALSE(written(name).readable) << name;
    }
}

}  // namespace
}  // namespace carat::synth
