// Heights against closed formulas and against GDAL's own reading, in every kind of CRS.
#include <gtest/gtest.h>

#include "carat/globe/error.hpp"
#include "raster_maker.hpp"

namespace carat::test {
namespace {

// The places of a raster, at random pixel coordinates at least `margin` pixels inside.
struct Place {
    double u, v;
    Vec3 n;
};

std::vector<Place> places_in(const RasterSpec& s, double margin, int count, unsigned seed) {
    const OGRSpatialReference raster = srs_of(s);
    OGRSpatialReference wgs84;
    wgs84.importFromEPSG(4326);
    wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRCoordinateTransformation> to_wgs84(
        OGRCreateCoordinateTransformation(&raster, &wgs84));
    std::mt19937_64 random(seed);
    std::vector<Place> places;
    for (int i = 0; i < count; ++i) {
        std::uniform_real_distribution<double> u(margin, s.width - margin), v(margin, s.height - margin);
        Place p{u(random), v(random), {}};
        auto [x, y] = to_crs(s, p.u, p.v);
        EXPECT_TRUE(to_wgs84->Transform(1, &x, &y));
        p.n = at(y, x);
        places.push_back(p);
    }
    return places;
}

constexpr double kOffBy = 1e-3;  // PixelCells::kBound: pixels that interpolated coordinates may be off by

// A function linear in pixel coordinates is reproduced exactly by bilinear and cubic kernels.
void expect_plane(const RasterSpec& s, double tolerance) {
    const Folder folder;
    const Value plane = [](double u, double v) { return 100 + 3 * u - 2 * v; };
    const std::string path = write_raster(folder.file("plane.tif"), s, plane);
    for (const Resampling r : {Resampling::bilinear, Resampling::cubic}) {
        const SourceStack stack = stack_of(path, r);
        double worst = 0;
        for (const Place& p : places_in(s, 2, 2000, 1)) {
            const auto value = stack.sample(p.n);
            ASSERT_EQ(value.layer, 0) << p.u << ' ' << p.v;
            worst = std::max(worst, std::abs(value.height - plane(p.u, p.v)));
        }
        EXPECT_LE(worst, tolerance) << to_string(r);
    }
}

TEST(SourceAccuracy, LatitudeLongitude) {
    RasterSpec s{300, 200};
    s.transform = {10, 0.01, 0, 50, 0, -0.01};
    expect_plane(s, 1e-7);
}
TEST(SourceAccuracy, SouthUpAndEastToWest) {
    RasterSpec s{300, 200};
    s.transform = {13, -0.01, 0, 48, 0, 0.01};
    expect_plane(s, 1e-7);
}
TEST(SourceAccuracy, Rotated) {
    RasterSpec s{300, 200};
    s.transform = {10, 0.008, 0.006, 50, 0.006, -0.008};
    expect_plane(s, 1e-7);
}
TEST(SourceAccuracy, Utm) {
    RasterSpec s{300, 200};
    s.transform = {400000, 30, 0, 5200000, 0, -30};
    s.epsg = 32633;
    expect_plane(s, 1e-5);
}
TEST(SourceAccuracy, RotatedUtm) {
    RasterSpec s{300, 200};
    s.transform = {400000, 24, 18, 5200000, 18, -24};
    s.epsg = 32633;
    expect_plane(s, 1e-5);
}
// EPSG:3031, polar stereographic; the raster contains the south pole.
TEST(SourceAccuracy, PolarStereographicOverThePole) {
    RasterSpec s{300, 200};
    s.transform = {-150000, 1000, 0, 100000, 0, -1000};
    s.epsg = 3031;
    expect_plane(s, 3.61 * kOffBy);  // the plane's slope
    const Folder folder;
    const std::string path =
        write_raster(folder.file("pole.tif"), s, [](double u, double v) { return u + 1000 * v; });
    EXPECT_NEAR(stack_of(path).sample({0, 0, -1}).height, 150 + 1000 * 100, 1e-6);
}
// A CRS whose axes EPSG orders north, east.
TEST(SourceAccuracy, NorthingEastingOrder) {
    RasterSpec s{300, 200};
    s.transform = {4500000, 50, 0, 5500000, 0, -50};
    s.epsg = 31468;  // Gauss-Kruger zone 4 on DHDN
    s.wkt = "+proj=tmerc +lat_0=0 +lon_0=12 +k=1 +x_0=4500000 +y_0=0 +ellps=WGS84 +units=m +axis=neu";
    expect_plane(s, 1e-5);
}
TEST(SourceAccuracy, FeetAsMapUnit) {
    RasterSpec s{300, 200};
    s.transform = {6000000, 100, 0, 2100000, 0, -100};
    s.epsg = 2229;  // California zone 5, US survey feet, NAD83
    expect_plane(
        s, 0.1);  // NAD83 to WGS 84: GDAL may choose another of the equally good operations, metres apart
}
TEST(SourceAccuracy, AntimeridianInDegrees) {
    RasterSpec s{300, 200};
    s.transform = {178.5, 0.01, 0, -15, 0, -0.01};
    expect_plane(s, 1e-7);
    s.transform = {-181.5, 0.01, 0, -15, 0, -0.01};
    expect_plane(s, 1e-7);
}
TEST(SourceAccuracy, AntimeridianInUtm) {
    RasterSpec s{300, 200};
    s.transform = {800000, 300, 0, 8100000, 0, -300};
    s.epsg = 32760;
    s.wkt = "+proj=tmerc +lat_0=0 +lon_0=177 +k=0.9996 +x_0=500000 +y_0=10000000 +datum=WGS84 +units=m";
    expect_plane(s, 3.61 * kOffBy);
}
TEST(SourceAccuracy, LongitudesFrom0To360) {
    RasterSpec s{720, 360};
    s.transform = {0, 0.5, 0, 90, 0, -0.5};
    const Folder folder;
    const std::string path =
        write_raster(folder.file("f.tif"), s, [](double u, double v) { return 10 * std::floor(u) + v; });
    const SourceStack stack = stack_of(path, Resampling::nearest);
    EXPECT_EQ(stack.sample(at(0.1, -179.9)).height, 10 * 360 + 179.5);
    EXPECT_EQ(stack.sample(at(0.1, 179.9)).height, 10 * 359 + 179.5);
    EXPECT_EQ(stack.sample(at(0.1, -0.1)).height, 10 * 719 + 179.5);
}

// GDAL's bilinear and cubic reading (in floats) of noise, away from the border (where GDAL has fewer samples,
// as have we).
TEST(SourceAccuracy, AgreesWithGdalsResampling) {
    const Folder folder;
    RasterSpec s{600, 500};
    s.transform = {10, 0.01, 0, 50, 0, -0.01};
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> noise(-1000, 1000);
    const std::string path =
        write_raster(folder.file("noise.tif"), s, [&](double, double) { return noise(random); });
    GDALDataset* d = GDALDataset::Open(path.c_str());
    for (const auto& [r, algorithm] :
         {std::pair{Resampling::bilinear, GRIORA_Bilinear}, std::pair{Resampling::cubic, GRIORA_Cubic}}) {
        const SourceStack stack = stack_of(path, r);
        for (const Place& p : places_in(s, 4, 3000, 3))
            ASSERT_NEAR(stack.sample(p.n).height, gdal_value(*d, p.u, p.v, algorithm), 2e-4)
                << to_string(r) << ' ' << p.u << ' ' << p.v;
    }
    GDALClose(d);
}

TEST(SourceAccuracy, DoublesKeepTheirBits) {
    const Folder folder;
    RasterSpec s{8, 8};
    const double exact = 1234.567890123456789;
    const std::string path = write_raster(folder.file("d.tif"), s, [&](double, double) { return exact; });
    EXPECT_EQ(stack_of(path).sample(at(-3.3, 4.4)).height, exact);
}

TEST(SourceAccuracy, ScaleOffsetAndUnit) {
    const Folder folder;
    RasterSpec s{8, 8};
    s.type = GDT_Int16;
    s.scale = 0.5;
    s.offset = 100;
    const Value raw = [](double u, double) { return std::floor(u) * 10; };
    EXPECT_EQ(stack_of(write_raster(folder.file("s.tif"), s, raw), Resampling::nearest)
                  .sample(at(-1.5, 3.5))
                  .height,
              100 + 0.5 * 30);
    s.unit = "ft";
    EXPECT_DOUBLE_EQ(stack_of(write_raster(folder.file("f.tif"), s, raw), Resampling::nearest)
                         .sample(at(-1.5, 3.5))
                         .height,
                     0.3048 * (100 + 0.5 * 30));
    s.unit = "fathom";
    EXPECT_EQ(stack_of(write_raster(folder.file("u.tif"), s, raw)).warnings().size(), 1u);
}

// Mars: a geographic raster of the sphere of equal equator means geodetic latitude unless told otherwise.
TEST(SourceAccuracy, GeocentricLatitudeOfMars) {
    const Folder folder;
    RasterSpec s{360, 180};
    s.transform = {-180, 1, 0, 90, 0, -1};
    s.wkt = "+proj=longlat +R=3396190 +no_defs";
    const Value latitude = [](double, double v) { return 90 - v; };
    LayerOptions options = layer_of(write_raster(folder.file("m.tif"), s, latitude));
    const Ellipsoid mars = Ellipsoid::mars();
    EXPECT_NEAR(stack_of({options}, mars).sample(at(40, 7)).height, 40, 1e-9);
    options.latitude = LatitudeKind::geocentric;
    const Vec3 n = at(40, 7);
    const Vec3 p = mars.position(n, 0);
    const double geocentric = std::atan2(p[2], std::hypot(p[0], p[1])) * 57.29577951308232;
    EXPECT_LT(geocentric, 39.7);
    EXPECT_NEAR(stack_of({options}, mars).sample(n).height, geocentric, 1e-9);
}
TEST(SourceAccuracy, MarsInPolarStereographic) {
    const Folder folder;
    RasterSpec s{200, 200};
    s.transform = {-1e5, 1000, 0, 1e5, 0, -1000};
    s.wkt = "+proj=stere +lat_0=90 +lon_0=0 +R=3396190 +units=m +no_defs";
    const std::string path =
        write_raster(folder.file("m.tif"), s, [](double u, double v) { return u + 1000 * v; });
    const SourceStack stack = stack_of({layer_of(path)}, Ellipsoid::mars());
    // Stereographic of a sphere: rho = 2 R tan((90 - lat)/2), x = rho sin lon, y = -rho cos lon.
    const double lat = 89, lon = 30, degree = 0.017453292519943295;
    const double rho = 2 * 3396190 * std::tan((90 - lat) / 2 * degree);
    const double u = 100 + rho * std::sin(lon * degree) / 1000, v = 100 + rho * std::cos(lon * degree) / 1000;
    EXPECT_NEAR(stack.sample(at(lat, lon)).height, u + 1000 * v, 1001 * kOffBy);
}

}  // namespace
}  // namespace carat::test
