// Lattice <-> geodetic normal against long double.
#include <gtest/gtest.h>

#include <algorithm>

#include "carat/globe/error.hpp"
#include "carat/globe/sphere.hpp"
#include "design_diamond.hpp"
#include "reference_math.hpp"

namespace carat::test {
namespace {

constexpr auto kE = static_cast<std::int32_t>(kLatticeExtent);
constexpr auto kExtent = static_cast<double>(kLatticeExtent);
// Round trips in lattice units: 2^-20 is 4 nm on Earth; a double resolves 2^-23 at the border of a face.
constexpr double kRoundTrip = 0x1p-20;

// Lattice points of every kind: random, near faces' borders, with tiny coordinates, cube edges and corners.
std::vector<LatticePoint> lattice_points(Random& random, int count) {
    std::vector<LatticePoint> out;
    for (int n = 0; n < count; ++n) {
        LatticeVector p = wide(random_target(random));
        const int face = faces_of(p).front();
        for (const int axis : {face_u_axis(face), face_v_axis(face)}) {
            const int kind = static_cast<int>(random.integer(0, 5));
            if (kind == 0) p.at(axis) = random.integer(-1000, 1000);
            if (kind == 1) p.at(axis) = kLatticeExtent - random.integer(0, 1000);
            if (kind == 2) p.at(axis) = random.integer(-1000, 1000) - kLatticeExtent;
        }
        if (on_lattice(p)) out.push_back(narrow(p));
    }
    return out;
}

TEST(Sphere, DirectionErrsByLessThanFourUlpByComponent) {
    Random random;
    SCOPED_TRACE(random.trace());
    Real worst = 0;
    for (const LatticePoint& p : lattice_points(random, 500'000)) {
        const Vec3 n = direction(p);
        const Real3 exact = reference_direction(wide_real(p));
        for (std::size_t k = 0; k < 3; ++k) worst = std::max(worst, ulps(n[k], exact[k]));
    }
    std::cout << "direction(lattice point): at most " << worst << " ulp by component\n";
    EXPECT_LT(worst, 4);
}

TEST(Sphere, DirectionOfRealCoordinatesErrsByLessThanFourUlp) {
    Random random;
    SCOPED_TRACE(random.trace());
    Real worst = 0;
    for (int n = 0; n < 300'000; ++n) {
        RealLattice r{static_cast<int>(random.integer(0, 5)), {}};
        for (double& c : r.coordinates)
            c = random.real(-kExtent, kExtent) * (random.chance(0.2) ? random.real(0, 1e-6) : 1.0);
        r.coordinates[static_cast<std::size_t>(face_axis(r.face))] = face_sign(r.face) * kExtent;
        const Vec3 d = direction(r);
        const Real3 exact = reference_direction(wide_real(r.coordinates));
        for (std::size_t k = 0; k < 3; ++k) worst = std::max(worst, ulps(d[k], exact[k]));
    }
    std::cout << "direction(real coordinates): at most " << worst << " ulp by component\n";
    EXPECT_LT(worst, 4);
}

TEST(Sphere, DirectionIsTheCompositionOfItsTwoSteps) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const LatticePoint& p : lattice_points(random, 100'000)) {
        const Vec3 w{lattice_tangent(p.x), lattice_tangent(p.y), lattice_tangent(p.z)};
        ASSERT_EQ(direction(p), direction_from_tangents(w)) << ::testing::PrintToString(p);
    }
}

TEST(Sphere, RealCoordinatesThatAreIntegersGiveTheSameBits) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const LatticePoint& p : lattice_points(random, 100'000))
        for (const int face : faces_of(wide(p))) {
            const RealLattice r{
                face, {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)}};
            ASSERT_EQ(direction(p), direction(r)) << ::testing::PrintToString(p);
        }
}

TEST(Sphere, TangentIsExactAtTheBorderAndTheMiddle) {
    EXPECT_EQ(equiangular_tan(1), 1.0);
    EXPECT_EQ(equiangular_tan(-1), -1.0);
    EXPECT_EQ(equiangular_tan(0), 0.0);
    EXPECT_EQ(lattice_tangent(kE), 1.0);
    EXPECT_EQ(lattice_tangent(-kE), -1.0);
}

TEST(Sphere, TangentIsOddAndIncreasing) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int n = 0; n < 200'000; ++n) {
        const auto x = static_cast<std::int32_t>(random.integer(-kE, kE - 1));
        ASSERT_LT(lattice_tangent(x), lattice_tangent(x + 1)) << x;
        ASSERT_EQ(lattice_tangent(-x), -lattice_tangent(x)) << x;
    }
    for (std::int32_t k = 1; k < 1000; ++k) {
        ASSERT_LT(lattice_tangent(kE - k), lattice_tangent(kE - k + 1)) << k;
        ASSERT_LT(lattice_tangent(-k), lattice_tangent(-k + 1)) << k;
    }
    EXPECT_LT(equiangular_tan(std::nextafter(1.0, 0.0)), 1.0);
}

TEST(Sphere, FaceCentresAndCubeCornersAreExact) {
    EXPECT_EQ(direction(LatticePoint{kE, 0, 0}), (Vec3{1, 0, 0}));
    EXPECT_EQ(direction(LatticePoint{0, -kE, 0}), (Vec3{0, -1, 0}));
    EXPECT_EQ(direction(LatticePoint{0, 0, kE}), (Vec3{0, 0, 1}));
    const Vec3 corner = direction(LatticePoint{kE, -kE, kE});
    EXPECT_EQ(corner[0], -corner[1]);
    EXPECT_EQ(corner[0], corner[2]);
    EXPECT_LT(ulps(corner[0], 1 / std::sqrt(Real{3})), 1);
}

TEST(Sphere, ContinuousAcrossCubeEdges) {
    // One step of the lattice off an edge into either face moves the normal by the same small angle.
    Random random;
    SCOPED_TRACE(random.trace());
    for (int n = 0; n < 50'000; ++n) {
        const int f = static_cast<int>(random.integer(0, 5));
        const int g = ((f & ~1) + 2 + static_cast<int>(random.integer(0, 3))) % 6;  // a face beside f
        LatticeVector p = kLatticeExtent * (face_normal(f) + face_normal(g));
        p.at(3 - face_axis(f) - face_axis(g)) = random.integer(-kLatticeExtent, kLatticeExtent);
        const Vec3 edge = direction(narrow(p));
        const Vec3 in_f = direction(narrow(p - face_normal(g))), in_g = direction(narrow(p - face_normal(f)));
        const Real to_f = length(wide_real(in_f) - wide_real(edge));
        const Real to_g = length(wide_real(in_g) - wide_real(edge));
        EXPECT_LT(to_f, 1e-9);  // 2^-30 pi/4 times at most sqrt(4/3)
        EXPECT_NEAR(static_cast<double>(to_f / to_g), 1, 1e-5);
        EXPECT_GT(to_f, 1e-10);
    }
}

TEST(Sphere, LatticePositionInvertsDirection) {
    Random random;
    SCOPED_TRACE(random.trace());
    double worst = 0;
    for (const LatticePoint& p : lattice_points(random, 300'000)) {
        const RealLattice r = lattice_position(direction(p));
        for (int k = 0; k < 3; ++k)
            worst = std::max(worst, std::abs(r.coordinates[static_cast<std::size_t>(k)] - p[k]));
        ASSERT_EQ(std::abs(r.coordinates[static_cast<std::size_t>(face_axis(r.face))]), kExtent);
        ASSERT_TRUE(on_face(p, r.face) || worst < kRoundTrip) << ::testing::PrintToString(p);
    }
    std::cout << "lattice -> normal -> lattice: at most " << worst << " lattice units\n";
    EXPECT_LT(worst, kRoundTrip);
}

TEST(Sphere, DirectionInvertsLatticePosition) {
    Random random;
    SCOPED_TRACE(random.trace());
    double worst = 0;
    for (int k = 0; k < 300'000; ++k) {
        Vec3 n = random_normal(random);
        if (k % 3 == 0) n[static_cast<std::size_t>(k / 3 % 3)] *= random.real(0, 1e-9);
        const Real3 exact = (1 / length(wide_real(n))) * wide_real(n);
        const double scale = std::ldexp(1.0, static_cast<int>(random.integer(-300, 300)));
        const Vec3 back = direction(lattice_position({n[0] * scale, n[1] * scale, n[2] * scale}));
        worst = std::max(worst, static_cast<double>(length(wide_real(back) - exact)));
    }
    std::cout << "normal -> lattice -> normal: at most " << worst << '\n';
    EXPECT_LT(worst, 1.2e-15);  // ten half-ulps of 1
}

TEST(Sphere, TiesGoToTheLowestFace) {
    EXPECT_EQ(lattice_position({1, 1, 1}).face, 0);
    EXPECT_EQ(lattice_position({-1, 1, 1}).face, 1);
    EXPECT_EQ(lattice_position({0.5, -1, 1}).face, 3);
    EXPECT_EQ(lattice_position({0, 0, -1e-300}).face, 5);
    const RealLattice corner = lattice_position({-2, 2, -2});
    EXPECT_EQ(corner.coordinates, (Vec3{-kExtent, kExtent, -kExtent}));
}

TEST(Sphere, DirectionsThatAreNoneAreRefused) {
    const double inf = std::numeric_limits<double>::infinity();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Vec3& v :
         {Vec3{0, 0, 0}, Vec3{-0.0, 0, 0}, Vec3{inf, 0, 0}, Vec3{1, -inf, 0}, Vec3{1, 0, nan}}) {
        try {
            lattice_position(v);
            ADD_FAILURE() << v[0] << ' ' << v[1] << ' ' << v[2];
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), ErrorCode::usage);
        }
    }
}

}  // namespace
}  // namespace carat::test
