// Geodetic normal <-> position against GeographicLib::Geocentric and long double, and round trips through the
// lattice.
#include <gtest/gtest.h>

#include <GeographicLib/Geocentric.hpp>
#include <algorithm>

#include "carat/globe/ellipsoid.hpp"
#include "carat/globe/error.hpp"
#include "design_diamond.hpp"
#include "reference_math.hpp"

namespace carat::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

Ellipsoid oblate() { return {6378137.0, 6378137.0 / 2}; }

std::vector<Ellipsoid> bodies() {
    return {Ellipsoid::earth(), Ellipsoid::moon(), Ellipsoid::mars(), oblate()};
}

// Poles, equator, antimeridian, cube edges and corners (as seen by the n-vector), and their near
// surroundings.
std::vector<Geodetic> hard_places() {
    const double corner = std::atan(std::sqrt(0.5)) * 180 / std::numbers::pi;
    std::vector<Geodetic> out;
    for (const double latitude : {90.0, 89.99999999, 60.0, corner, 45.0, 1e-12, 0.0})
        for (const double longitude : {0.0, 1e-12, 44.9999999999, 45.0, 90.0, 135.0, 179.99999999999, 180.0})
            for (const double s : {-1.0, 1.0})
                for (const double t : {-1.0, 1.0}) out.push_back({s * latitude, t * longitude});
    return out;
}

std::vector<Geodetic> places(Random& random, int count) {
    std::vector<Geodetic> out = hard_places();
    for (int n = 0; n < count; ++n) out.push_back({random.real(-90, 90), random.real(-180, 180)});
    return out;
}

double distance(const Vec3& p, const Vec3& q) {
    return static_cast<double>(length(wide_real(p) - wide_real(q)));
}

TEST(Ellipsoid, AgreesWithGeographicLibToTenNanometres) {
    Random random;
    SCOPED_TRACE(random.trace());
    const std::vector<Geodetic> all = places(random, 100'000);
    for (const Ellipsoid& body : bodies()) {
        const GeographicLib::Geocentric reference(body.a(), (body.a() - body.b()) / body.a());
        double worst = 0;
        for (const Geodetic& g : all)
            for (const double h : {0.0, -10e3, random.real(-10e3, 100e3), 100e3}) {
                Vec3 expected{};
                reference.Forward(g.latitude, g.longitude, h, expected[0], expected[1], expected[2]);
                worst = std::max(worst, distance(body.position(direction(g), h), expected));
            }
        std::cout << body.name() << ' ' << body.a() << ", " << body.b() << ": " << worst * 1e9
                  << " nm from GeographicLib\n";
        EXPECT_LT(worst, 10e-9) << body.name();
    }
}

TEST(Ellipsoid, PositionAgreesWithLongDouble) {
    Random random;
    SCOPED_TRACE(random.trace());
    std::vector<Ellipsoid> all = bodies();
    all.emplace_back(1000.0, 700.0);
    all.emplace_back(71492e3, 66854e3);
    for (const Ellipsoid& body : all) {
        Real worst = 0;
        for (int n = 0; n < 100'000; ++n) {
            const Vec3 normal = direction(random_target(random));
            const double h = body.a() * random.real(-0.005, 0.02);
            const Real3 exact = reference_position(body, wide_real(normal), h);
            worst = std::max(worst, length(wide_real(body.position(normal, h)) - exact));
        }
        EXPECT_LT(worst / body.a(), 6e-16) << body.a() << ", " << body.b();  // 4 nm on Earth
    }
}

TEST(Ellipsoid, SurfacePointsSolveTheQuadricAndTheNormalIsItsGradient) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const Ellipsoid& body : bodies())
        for (int k = 0; k < 20'000; ++k) {
            const Vec3 n = random_normal(random);
            const Real3 p = wide_real(body.position(n, 0));
            const Real a2 = static_cast<Real>(body.a()) * body.a(),
                       b2 = static_cast<Real>(body.b()) * body.b();
            const Real3 gradient{p[0] / a2, p[1] / a2, p[2] / b2};
            ASSERT_NEAR(static_cast<double>(dot(gradient, p)), 1, 1e-15);
            ASSERT_NEAR(static_cast<double>(dot(gradient, wide_real(n)) / length(gradient)), 1, 1e-15);
        }
}

TEST(Ellipsoid, NormalHeightInvertsPosition) {
    Random random;
    SCOPED_TRACE(random.trace());
    const std::vector<Geodetic> all = places(random, 50'000);
    for (const Ellipsoid& body : bodies()) {
        double worst_height = 0, worst_normal = 0;
        for (const Geodetic& g : all)
            for (const double h : {-10e3, random.real(-10e3, 100e3), 100e3}) {
                const Vec3 n = direction(g);
                const Ellipsoid::NormalHeight back = body.normal_height(body.position(n, h));
                worst_height = std::max(worst_height, std::abs(back.height - h));
                worst_normal = std::max(worst_normal, distance(back.normal, n) * body.a());
            }
        std::cout << body.name() << ' ' << body.a() << ", " << body.b() << ": height " << worst_height * 1e9
                  << " nm, normal " << worst_normal * 1e9 << " nm at radius a\n";
        EXPECT_LT(worst_height, 1e-6);
        EXPECT_LT(worst_normal, 1e-6);
    }
}

// The whole circle: position -> normal and height -> lattice coordinates -> position.
void expect_round_trip(const Ellipsoid& body, const Vec3& n, double h, double& worst) {
    const Vec3 p = body.position(n, h);
    const Ellipsoid::NormalHeight nh = body.normal_height(p);
    const Vec3 back = body.position(direction(lattice_position(nh.normal)), nh.height);
    worst = std::max(worst, distance(p, back));
}

TEST(Ellipsoid, RoundTripThroughTheLatticeIsBelowAMicrometre) {
    Random random;
    SCOPED_TRACE(random.trace());
    const std::vector<Geodetic> all = places(random, 30'000);
    for (const Ellipsoid& body : bodies()) {
        double worst = 0;
        const auto heights = [&] { return std::array{-10e3, 0.0, random.real(-10e3, 100e3), 100e3}; };
        for (const Geodetic& g : all)
            for (const double h : heights()) expect_round_trip(body, direction(g), h, worst);
        for (int k = 0; k < 30'000; ++k)  // cube edges and corners by their lattice points
            for (const double h : heights())
                expect_round_trip(body, direction(random_target(random)), h, worst);
        std::cout << body.name() << ' ' << body.a() << ", " << body.b() << ": " << worst * 1e9
                  << " nm round trip\n";
        EXPECT_LT(worst, 1e-6);
    }
}

TEST(Geodetic, DirectionIsExactAtPolesEquatorAndAntimeridian) {
    EXPECT_EQ(direction(Geodetic{90, 0}), (Vec3{0, 0, 1}));
    EXPECT_EQ(direction(Geodetic{90, 123.4}), (Vec3{0, 0, 1}));
    EXPECT_EQ(direction(Geodetic{-90, -77}), (Vec3{0, 0, -1}));
    EXPECT_EQ(direction(Geodetic{0, 0}), (Vec3{1, 0, 0}));
    EXPECT_EQ(direction(Geodetic{0, 90}), (Vec3{0, 1, 0}));
    EXPECT_EQ(direction(Geodetic{0, -90}), (Vec3{0, -1, 0}));
    EXPECT_EQ(direction(Geodetic{0, 180}), (Vec3{-1, 0, 0}));
    for (const double latitude : {-90.0, -51.5, 0.0, 12.25, 90.0})
        for (const double turn : {-540.0, -180.0, 540.0}) {
            const Vec3 west = direction(Geodetic{latitude, turn}), east = direction(Geodetic{latitude, 180});
            EXPECT_EQ(west, east);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(std::signbit(west[k]), std::signbit(east[k]));
        }
}

TEST(Geodetic, InvertsDirection) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const Geodetic& g : places(random, 100'000)) {
        const Geodetic back = geodetic(direction(g));
        ASSERT_NEAR(back.latitude, g.latitude, 3e-14);
        if (std::abs(g.latitude) == 90) {
            ASSERT_EQ(back.longitude, 0) << g.latitude;
            continue;
        }
        const double turn = std::abs(back.longitude - g.longitude);
        const double off = std::min(turn, 360 - turn) * std::cos(g.latitude * std::numbers::pi / 180);
        ASSERT_LT(off, 3e-14) << g.latitude << ' ' << g.longitude;
        ASSERT_LE(std::abs(back.longitude), 180);
    }
}

TEST(Geodetic, ZerosOfEitherSignArePlacesOfOneName) {
    for (const double x : {0.0, -0.0})
        for (const double y : {0.0, -0.0}) EXPECT_EQ(geodetic({x, y, 1}).longitude, 0) << x << ' ' << y;
    EXPECT_EQ(geodetic({-1, -0.0, 0}).longitude, 180);
    EXPECT_EQ(geodetic({0, 0, -2}).latitude, -90);
}

template <class Call>
void expect_usage_error(Call call, const char* what) {
    try {
        call();
        ADD_FAILURE() << what << ": no error";
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::usage) << what;
        EXPECT_FALSE(std::string(e.what()).empty());
    }
}

TEST(Geodetic, PlacesThatAreNoneAreRefused) {
    expect_usage_error([] { direction(Geodetic{90.0000001, 0}); }, "latitude above 90");
    expect_usage_error([] { direction(Geodetic{-91, 0}); }, "latitude below -90");
    expect_usage_error([] { direction(Geodetic{kNan, 0}); }, "latitude NaN");
    expect_usage_error([] { direction(Geodetic{0, kInf}); }, "longitude infinite");
    expect_usage_error([] { direction(Geodetic{0, kNan}); }, "longitude NaN");
}

TEST(Ellipsoid, DegenerateBodiesAreRefused) {
    const std::array<std::array<double, 2>, 13> axes{{{0, 0},
                                                      {1, 0},
                                                      {-1, -1},
                                                      {1, 2},
                                                      {kNan, 1},
                                                      {1, kNan},
                                                      {kInf, 1},
                                                      {kInf, kInf},
                                                      {1, -1},
                                                      {1e200, 1e200},    // squares overflow
                                                      {1e-200, 1e-200},  // squares vanish
                                                      {1e7, 1e-3},       // a disc
                                                      {1000, 99.9}}};
    for (const auto& [a, b] : axes)
        expect_usage_error(
            [a = a, b = b] {
                Ellipsoid{a, b};
            },
            (std::to_string(a) + ", " + std::to_string(b)).c_str());
}

TEST(Ellipsoid, DegeneratePositionsAreRefusedAndTheCentreIsNot) {
    const Ellipsoid earth = Ellipsoid::earth();
    expect_usage_error([&] { earth.normal_height({kNan, 0, 0}); }, "NaN");
    expect_usage_error([&] { earth.normal_height({0, kInf, 0}); }, "infinite");
    for (const Vec3& p :
         {Vec3{0, 0, 0}, Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0, 0, -1e12}, Vec3{1e300, 1e300, 0}}) {
        const Ellipsoid::NormalHeight nh = earth.normal_height(p);
        EXPECT_NEAR(static_cast<double>(length(wide_real(nh.normal))), 1, 1e-15);
        EXPECT_TRUE(std::isfinite(nh.height));
    }
}

TEST(Ellipsoid, ParsesNamesAndAxes) {
    EXPECT_EQ(Ellipsoid::parse("earth"), Ellipsoid::earth());
    EXPECT_EQ(Ellipsoid::parse("moon").name(), "moon");
    EXPECT_EQ(Ellipsoid::parse("mars").b(), 3376200);
    EXPECT_EQ(Ellipsoid::parse("6378137,6356752.5"), Ellipsoid(6378137, 6356752.5));
    EXPECT_EQ(Ellipsoid::parse("1e3,500").b(), 500);
    for (const char* text : {"", "venus", "Earth", "1000", "1000,", ",1000", "1000,900,800", "1000, 900",
                             "900,1000", "nan,nan", "inf,inf", "1000,900 ", "0,0", "-1,-1", "1e999,1e999"})
        expect_usage_error([&] { Ellipsoid::parse(text); }, text);
}

TEST(Ellipsoid, CurvatureRadiiAreTheExtremesOfBothPrincipalRadii) {
    for (const Ellipsoid& body : bodies()) {
        const double e2 = 1 - body.b() / body.a() * (body.b() / body.a());
        double least = kInf, most = 0;
        for (double latitude = 0; latitude <= 90; latitude += 0.5) {
            const double s = std::sin(latitude * std::numbers::pi / 180);
            const double w = std::sqrt(1 - e2 * s * s);
            for (const double r : {body.a() / w, body.a() * (1 - e2) / (w * w * w)}) {
                least = std::min(least, r);
                most = std::max(most, r);
            }
        }
        EXPECT_NEAR(body.min_curvature_radius() / least, 1, 1e-12);
        EXPECT_NEAR(body.max_curvature_radius() / most, 1, 1e-12);
    }
}

}  // namespace
}  // namespace carat::test
