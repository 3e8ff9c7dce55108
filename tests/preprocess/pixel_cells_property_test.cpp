// Interpolated pixel coordinates are within PixelCells::kBound of PROJ's, whatever the projection, and depend
// on the place alone.
#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <thread>

#include "frame.hpp"
#include "gdal_errors.hpp"
#include "pixel_cells.hpp"

namespace carat::test {
namespace {

struct Map {
    const char* name;
    int epsg;
    double x, y, pixel;  // upper left corner, size of a pixel
    int pixels;          // a side
};

std::ostream& operator<<(std::ostream& out, const Map& m) { return out << m.name; }

class PixelCellsTest : public testing::TestWithParam<Map> {
  protected:
    PixelCellsTest() : frame_(make(GetParam())) {}

    static Frame make(const Map& m) {
        initialise_gdal();
        OGRSpatialReference srs;
        srs.importFromEPSG(m.epsg);
        char* wkt = nullptr;
        srs.exportToWkt(&wkt);
        std::vector<std::string> warnings;
        const double side = m.pixel * m.pixels;
        const auto crs = Crs::of_wkt(wkt, {m.x, m.y - side, m.x + side, m.y}, Ellipsoid::earth(),
                                     LatitudeKind::automatic, m.name, warnings);
        CPLFree(wkt);
        return {crs, {m.x, m.pixel, 0, m.y, 0, -m.pixel}, m.pixels, m.pixels, m.name};
    }
    // Places all over the raster, or all over one `times` as large around it.
    void scatter(std::size_t count, unsigned seed, double times = 1) {
        std::mt19937 random(seed);
        const double n = GetParam().pixels, beyond = (times - 1) / 2 * n;
        std::uniform_real_distribution<double> at(0.5 - beyond, n - 0.5 + beyond);
        for (std::size_t k = 0; k < count; ++k)
            if (const auto normal = frame_.normal(at(random), at(random))) normals_.push_back(*normal);
        lat_.resize(normals_.size());
        lon_.resize(normals_.size());
        to_degrees(normals_, lat_, lon_);
    }

    Frame frame_;
    std::vector<Vec3> normals_;
    std::vector<double> lat_, lon_;
};

TEST_P(PixelCellsTest, WithinTheBoundOfProj) {
    scatter(20000, 1);
    ASSERT_GT(lat_.size(), 15000u);
    const std::size_t n = lat_.size();
    std::vector<double> u(n), v(n), exact_u(n), exact_v(n);
    frame_.to_pixels(lat_, lon_, u, v);
    frame_.to_unbounded_pixels(lat_, lon_, exact_u, exact_v);
    double worst = 0;
    std::size_t interpolated = 0;
    for (std::size_t k = 0; k < n; ++k) {
        const double off = std::hypot(u[k] - exact_u[k], v[k] - exact_v[k]);
        ASSERT_LE(off, PixelCells::kBound) << lat_[k] << ' ' << lon_[k];
        worst = std::max(worst, off);
        interpolated += off > 0 ? 1 : 0;
    }
    RecordProperty("worst", std::to_string(worst));
    std::printf("%s: worst %.7f pixels, %.1f %% interpolated\n", GetParam().name, worst,
                100.0 * static_cast<double>(interpolated) / static_cast<double>(n));
    EXPECT_GT(interpolated, n / 2) << "or nothing is gained";
}

TEST_P(PixelCellsTest, WhatIsOutsideIsSoByProj) {
    scatter(10000, 3, 4);
    const std::size_t n = lat_.size();
    std::vector<double> u(n), v(n), exact_u(n), exact_v(n);
    frame_.to_pixels(lat_, lon_, u, v);
    frame_.to_unbounded_pixels(lat_, lon_, exact_u, exact_v);
    const double size = GetParam().pixels, edge = PixelCells::kBound;
    const auto within = [&](std::size_t k, double margin) {
        return exact_u[k] > margin && exact_u[k] < size - margin && exact_v[k] > margin &&
               exact_v[k] < size - margin;
    };
    for (std::size_t k = 0; k < n; ++k)
        if (std::isnan(u[k]))
            EXPECT_FALSE(within(k, edge)) << exact_u[k] << ' ' << exact_v[k];
        else
            EXPECT_TRUE(within(k, -edge)) << exact_u[k] << ' ' << exact_v[k];
}

TEST_P(PixelCellsTest, AFunctionOfThePlaceAlone) {
    scatter(6000, 2);
    const std::size_t n = lat_.size();
    std::vector<double> u(n), v(n);
    frame_.to_pixels(lat_, lon_, u, v);
    const auto check = [&](std::size_t first, std::size_t stride) {
        for (std::size_t k = first; k < n; k += stride) {
            double one_u = 0, one_v = 0;
            frame_.to_pixels({&lat_[k], 1}, {&lon_[k], 1}, {&one_u, 1}, {&one_v, 1});
            EXPECT_EQ(one_u, u[k]);
            EXPECT_EQ(one_v, v[k]);
        }
    };
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < 3; ++t) threads.emplace_back([&, t] { check(t, 3); });
    for (std::thread& t : threads) t.join();
}

INSTANTIATE_TEST_SUITE_P(Projections, PixelCellsTest,
                         testing::Values(Map{"RD_half_metre", 28992, 120000, 487000, 0.5, 1000},
                                         Map{"RD_country", 28992, 10000, 620000, 25, 10000},
                                         Map{"UTM_33_10m", 32633, 400000, 5400000, 10, 10000},
                                         Map{"UTM_33_far_from_its_meridian", 32633, -600000, 5400000, 90,
                                             3000},
                                         Map{"Greek_grid", 2100, 470000, 4210000, 1, 400},
                                         Map{"Antarctica_pole_1km", 3031, -500000, 500000, 1000, 1000},
                                         Map{"Antarctica_pole_10m", 3031, -3000, 3000, 10, 600},
                                         Map{"Svalbard_UTM_20m", 25833, 430000, 8770000, 20, 10000},
                                         Map{"LAEA_Europe_1km", 3035, 2500000, 5500000, 1000, 3000},
                                         Map{"DHDN_degrees", 4314, 8, 50, 0.001, 3000}),
                         [](const auto& map) { return std::string(map.param.name); });

}  // namespace
}  // namespace carat::test
