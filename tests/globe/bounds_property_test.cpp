// The bounds of halves really bound: dense random sampling in long double on bodies from a small asteroid to
// Jupiter and very oblate ones. How lazy each bound is, is printed and recorded.
#include <gtest/gtest.h>

#include <GeographicLib/Ellipsoid.hpp>
#include <algorithm>
#include <sstream>

#include "carat/globe/bounds.hpp"
#include "design_diamond.hpp"
#include "diamond_levels.hpp"
#include "reference_math.hpp"

namespace carat::test {
namespace {

// A grid triangle of level 40 sags by less than a nanometre: deeper, long double has nothing to measure.
constexpr int kLastSagging = 40;
constexpr Real kRadian =
    std::numbers::pi_v<Real> / 4 / static_cast<Real>(kLatticeExtent);  // per lattice unit

struct Body {
    const char* name;
    Ellipsoid shape;
};
std::vector<Body> bodies() {
    return {{"earth", Ellipsoid::earth()},
            {"moon", Ellipsoid::moon()},
            {"mars", Ellipsoid::mars()},
            {"jupiter", {71492e3, 66854e3}},
            {"half as high as wide", {6378137, 6378137.0 / 2}},
            {"a fifth as high as wide", {6378137, 6378137.0 / 5}},
            {"asteroid of 1 km", {1000, 1000}},
            {"oblate asteroid of 1 km", {1000, 500}}};
}

// 100 km on Earth; in proportion elsewhere.
double highest(const Ellipsoid& body) { return body.a() * (100.0 / 6378); }

Real3 real3(const LatticeVector& v) {
    return {static_cast<Real>(v.x), static_cast<Real>(v.y), static_cast<Real>(v.z)};
}

// A random place of a triangle in barycentric coordinates, often on an edge or in the middle.
Real3 barycentric(Random& random) {
    if (random.chance(0.1)) return {1 / Real{3}, 1 / Real{3}, 1 / Real{3}};
    Real3 w{random.real(0, 1), random.real(0, 1), random.real(0, 1)};
    if (random.chance(0.3)) w[static_cast<std::size_t>(random.integer(0, 2))] = 0;
    if (random.chance(0.3)) w = {Real{1} / 2, Real{1} / 2, 0};  // middle of the first side
    return (1 / (w[0] + w[1] + w[2])) * w;
}

Real3 blend(const Real3& w, const std::array<Real3, 3>& v) { return w[0] * v[0] + w[1] * v[1] + w[2] * v[2]; }

std::array<Real3, 3> corners_of(const Half& h) {  // a, b, x: the first side is the longest edge
    const DiamondCorners c = corners(h.diamond);
    return {wide_real(c.a), wide_real(c.b), wide_real(c.x[static_cast<std::size_t>(h.side)])};
}

// A triangle of the half's grid; the first side is its longest.
std::array<Real3, 3> grid_triangle(Random& random, const Half& h, int cells) {
    const HalfFrame f = half_frame(h, cells);
    const auto pick = [&] {
        return static_cast<int>(random.chance(0.3) ? random.integer(0, 1) * (cells - 1)
                                                   : random.integer(0, cells - 1));
    };
    int high = pick(), low = pick();
    if (high < low) std::swap(high, low);
    const int i = h.side == 0 ? high : low, j = h.side == 0 ? low : high;
    const auto at = [&](int x, int y) { return real3(f.origin + x * f.u + y * f.v); };
    const bool main = high == low || random.chance(0.5);
    const bool first = high == low ? h.side == 0 : random.chance(0.5);
    if (main) return {at(i, j), at(i + 1, j + 1), first ? at(i + 1, j) : at(i, j + 1)};
    return {at(i + 1, j), at(i, j + 1), first ? at(i, j) : at(i + 1, j + 1)};
}

// Greatest ratio of truth to bound by level; 1 is tight, above 1 is a lie.
class Tightness {
  public:
    explicit Tightness(std::string what) : what_(std::move(what)) {}

    void add(int level, Real truth, Real bound) {
        if (bound > 0) ratio_[static_cast<std::size_t>(level)] = std::max(ratio_.at(level), truth / bound);
        EXPECT_LE(truth, bound) << what_ << " on level " << level;
    }

    ~Tightness() {
        std::ostringstream text;
        text.precision(3);
        for (const int level : {0, 1, 2, 4, 6, 8, 10, 14, 20, 30, 40, 50})
            if (ratio_[static_cast<std::size_t>(level)] > 0)
                text << "  " << level << ": " << 1 / ratio_[static_cast<std::size_t>(level)];
        std::cout << what_ << ", bound over greatest sampled value by level:" << text.str() << '\n';
        ::testing::Test::RecordProperty("laziness_" + std::to_string(serial_++), what_ + text.str());
    }

  private:
    static inline int serial_ = 0;
    std::string what_;
    std::array<Real, kDeepestId + 1> ratio_{};
};

template <class Visit>
void for_levels(Random& random, int last_level, int count, Visit visit) {
    for (int level = 0; level <= last_level; ++level)
        for (int n = 0; n < count; ++n) visit(Half{random_diamond(random, level), n % 2}, level);
}

TEST(Bounds, SagittaOfEllipsoidAndNormal) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const auto& [name, body] : bodies()) {
        Tightness ellipsoid(std::string("sagitta of ") + name),
            normal(std::string("sagitta of the normal, ") + name),
            change(std::string("change of the normal, ") + name);
        for_levels(random, kLastSagging, 30, [&, &shape = body](const Half& h, int level) {
            const int cells = std::array{1, 8, 64}[static_cast<std::size_t>(random.integer(0, 2))];
            const CurvatureBound bound = curvature_bound(shape, h, cells);
            for (int t = 0; t < 8; ++t) {
                const std::array<Real3, 3> corner = grid_triangle(random, h, cells);
                std::array<Real3, 3> n{}, p{};
                for (std::size_t k = 0; k < 3; ++k) {
                    n[k] = reference_direction(corner[k]);
                    p[k] = reference_position(shape, n[k], 0);
                }
                const Real rounding = 1e-17L;  // of long double, relative to a
                for (int s = 0; s < 8; ++s) {
                    const Real3 w = barycentric(random);
                    const Real3 at = reference_direction(blend(w, corner));
                    const Real sagitta = length(reference_position(shape, at, 0) - blend(w, p));
                    ellipsoid.add(level, sagitta, bound.ellipsoid_sagitta + rounding * shape.a());
                    normal.add(level, length(at - blend(w, n)), bound.normal_sagitta + rounding);
                    change.add(level, length(at - n[2]), bound.normal_change + rounding);
                }
                change.add(level, length(n[0] - n[1]), bound.normal_change + rounding);
            }
        });
    }
}

TEST(Bounds, FlatTrianglesStayWithinOfHeightsFromTheSurface) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const auto& [name, body] : bodies()) {
        Tightness surface(std::string("flat triangles of ") + name);
        for_levels(random, kLastSagging, 30, [&, &shape = body](const Half& h, int level) {
            const int cells = random.chance(0.5) ? 64 : 4;
            const CurvatureBound bound = curvature_bound(shape, h, cells);
            for (int t = 0; t < 8; ++t) {
                const std::array<Real3, 3> corner = grid_triangle(random, h, cells);
                const double top = highest(shape);
                const Real3 height{random.real(-top, top), random.chance(0.5) ? top : -top,
                                   random.real(-top, top)};
                const auto [low, high] = std::minmax_element(height.begin(), height.end());
                const double range = static_cast<double>(*high - *low);
                const Real limit = bound.of_heights(top, range) + 1e-17L * shape.a();
                std::array<Real3, 3> p{};
                for (std::size_t k = 0; k < 3; ++k)
                    p[k] = reference_position(shape, reference_direction(corner[k]), height[k]);
                for (int s = 0; s < 8; ++s) {
                    const Real3 w = barycentric(random);
                    const Real3 at =
                        reference_position(shape, reference_direction(blend(w, corner)), dot(w, height));
                    surface.add(level, length(at - blend(w, p)), limit);
                }
            }
        });
    }
}

TEST(Bounds, BallHoldsTheHalfAtAllHeights) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const auto& [name, body] : bodies()) {
        Tightness ball_tightness(std::string("bounding ball of ") + name);
        for_levels(random, kDeepestId, 40, [&, &shape = body](const Half& h, int level) {
            const double top = highest(shape);
            double low = random.real(-top, top), high = random.chance(0.3) ? low : random.real(-top, top);
            if (low > high) std::swap(low, high);
            const BoundingBall ball = bounding_ball(shape, h, low, high);
            const std::array<Real3, 3> corner = corners_of(h);
            for (int s = 0; s < 60; ++s) {
                // The three corners first, then anywhere.
                const Real3 w =
                    s < 6 ? Real3{s % 3 == 0 ? 1.0L : 0, s % 3 == 1 ? 1.0L : 0, s % 3 == 2 ? 1.0L : 0}
                          : barycentric(random);
                const double height = s % 2 == 0 ? low : random.chance(0.5) ? high : random.real(low, high);
                const Real3 n = reference_direction(blend(w, corner));
                const Real3 exact = reference_position(shape, n, height);
                ball_tightness.add(level, length(exact - wide_real(ball.centre)), ball.radius);
                // What the renderer computes, rounded to double, must be inside too.
                const Vec3 rounded = shape.position(
                    {static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])},
                    height);
                ball_tightness.add(level, length(wide_real(rounded) - wide_real(ball.centre)), ball.radius);
            }
        });
    }
}

TEST(Bounds, ConeHoldsTheNormals) {
    Random random;
    SCOPED_TRACE(random.trace());
    Tightness cone_tightness("normal cone (sine of the angle)");
    for_levels(random, kDeepestId, 200, [&](const Half& h, int level) {
        const NormalCone cone = normal_cone(h);
        const Real3 axis = wide_real(cone.axis);
        EXPECT_NEAR(static_cast<double>(length(axis)), 1, 1e-15);
        EXPECT_NEAR(cone.cos_angle * cone.cos_angle + cone.sin_angle * cone.sin_angle, 1, 1e-15);
        EXPECT_GT(cone.cos_angle, 0) << "sines compare angles only below a right angle";
        const std::array<Real3, 3> corner = corners_of(h);
        for (int s = 0; s < 60; ++s) {
            const Real3 w =
                s < 3 ? Real3{s == 0 ? 1.0L : 0, s == 1 ? 1.0L : 0, s == 2 ? 1.0L : 0} : barycentric(random);
            const Real3 n = reference_direction(blend(w, corner));
            const Real chord = length(n - axis);
            cone_tightness.add(level, chord * std::sqrt(1 - chord * chord / 4), cone.sin_angle);
            EXPECT_GE(static_cast<double>(dot(n, axis)), cone.cos_angle - 1e-15);
        }
    });
}

// --- the constants and lemmas behind the bounds

Real3 normal_at(Real phi, Real psi) {
    const Real3 w{1, std::tan(phi), std::tan(psi)};
    return (1 / length(w)) * w;
}

// Greatest first, second and third directional derivative of a map over a face, by angle.
struct Derivatives {
    Real first = 0, second = 0, third = 0;
};
template <class Map>
Derivatives derivatives(int grid, int directions, Map map) {
    constexpr Real kStep = 1e-4L;
    Derivatives d;
    for (int i = -grid; i <= grid; ++i)
        for (int j = -grid; j <= grid; ++j)
            for (int k = 0; k < directions; ++k) {
                const Real phi = std::numbers::pi_v<Real> / 4 * i / grid,
                           psi = std::numbers::pi_v<Real> / 4 * j / grid;
                const Real angle = std::numbers::pi_v<Real> * k / directions;
                const auto at = [&](Real t) {
                    return map(phi + t * kStep * std::cos(angle), psi + t * kStep * std::sin(angle));
                };
                const Real3 centre = at(0), plus = at(1), minus = at(-1), plus2 = at(2), minus2 = at(-2);
                d.first = std::max(d.first, length(plus - minus) / (2 * kStep));
                d.second = std::max(d.second, length(plus - centre - (centre - minus)) / (kStep * kStep));
                d.third = std::max(
                    d.third, length((plus2 - minus2) - 2 * (plus - minus)) / (2 * kStep * kStep * kStep));
            }
    return d;
}

TEST(Bounds, ConstantsOfTheNormalAreTheGreatestDerivatives) {
    const Derivatives d = derivatives(20, 36, normal_at);
    // The constants, recovered from the bounds they make.
    const Half h{root_diamond(0), 0};
    const CurvatureBound bound = curvature_bound(Ellipsoid::earth(), h, 1);
    const Real hypotenuse = std::numbers::pi_v<Real> / 2 * std::numbers::sqrt2_v<Real>;
    const Real first = bound.normal_change / hypotenuse,
               second = 8 * bound.normal_sagitta / (hypotenuse * hypotenuse);
    std::cout << "normal by angle: first derivative " << d.first << " (bound " << first << "), second "
              << d.second << " (bound " << second << ")\n";
    EXPECT_LE(d.first, first);
    EXPECT_LE(d.second, second);
    EXPECT_NEAR(static_cast<double>(d.first), std::sqrt(4.0 / 3), 1e-6);
    EXPECT_NEAR(static_cast<double>(d.second), std::sqrt(8.0 / 3), 1e-6);
}

TEST(Bounds, DerivativesOfTheWholeBodyAreBounds) {
    std::vector<Body> all = bodies();
    all.push_back({"a tenth as high as wide", {1000, 100}});
    for (const auto& [name, body] : all) {
        Derivatives d;
        for (const int axis : {0, 2}) {  // an equatorial and a polar face
            const Derivatives f = derivatives(20, 24, [&, &shape = body](Real phi, Real psi) {
                const Real3 n = normal_at(phi, psi);
                return reference_position(shape, axis == 0 ? n : Real3{n[1], n[2], n[0]}, 0);
            });
            d = {std::max(d.first, f.first), std::max(d.second, f.second), std::max(d.third, f.third)};
        }
        std::cout << name << ": second derivative " << d.second / body.a() << " a (bound "
                  << body.second_derivative_bound() / body.a() << "), third " << d.third / body.a()
                  << " a (bound " << body.third_derivative_bound() / body.a() << ")\n";
        EXPECT_LE(d.second, body.second_derivative_bound()) << name;
        EXPECT_LE(d.third, body.third_derivative_bound()) << name;
        EXPECT_LE(body.second_derivative_bound(), 1.1 * d.second) << name;
        EXPECT_LE(body.third_derivative_bound(), 1.15 * d.third) << name;
    }
}

// From its centroid a half reaches no farther than 0.54 of its longest edge, by face angle.
TEST(Bounds, CentroidIsWithin54PercentOfTheLongestEdge) {
    for_all([](DiamondId d, int) {
        for (const int side : {0, 1}) {
            const std::array<Real3, 3> k = corners_of({d, side});
            const Real3 centroid = blend({1 / Real{3}, 1 / Real{3}, 1 / Real{3}}, k);
            for (const Real3& corner : k) ASSERT_LT(length(corner - centroid), 0.54L * length(k[0] - k[1]));
        }
    });
}

// Interpolation over a right triangle errs by at most M hypotenuse^2 / 8: sharp for a quadratic.
TEST(Bounds, InterpolationErrorIsSharpForAQuadratic) {
    const auto f = [](Real x, Real y) {
        return (x * x + y * y) / 2;
    };  // second derivative 1 in every direction
    Real worst = 0;
    for (int i = 0; i <= 100; ++i)
        for (int j = 0; j <= 100 - i; ++j) {
            const Real x = i / Real{100}, y = j / Real{100};
            worst = std::max(worst, std::abs(f(x, y) - (x * f(1, 0) + y * f(0, 1))));
        }
    EXPECT_NEAR(static_cast<double>(worst), 2.0 / 8, 1e-12);  // hypotenuse^2 = 2
}

// --- sample spacing

// Area of a half in m^2: area element of the normal's sphere over the Gaussian curvature, by midpoints.
Real area(const Ellipsoid& body, const Half& h, int cells) {
    const std::array<Real3, 3> corner = corners_of(h);
    const Real a2 = static_cast<Real>(body.a()) * body.a(), b2 = static_cast<Real>(body.b()) * body.b();
    const Real leg = length(corner[0] - corner[2]) * kRadian;
    Real sum = 0;
    const auto add = [&](Real x, Real y) {  // middle of a small triangle
        const Real3 place = corner[2] + x * (corner[0] - corner[2]) + y * (corner[1] - corner[2]);
        const Real3 w{reference_tan(place[0] / kLatticeExtent), reference_tan(place[1] / kLatticeExtent),
                      reference_tan(place[2] / kLatticeExtent)};
        const Real w2 = dot(w, w);
        Real sphere = 1;
        for (const Real t : w) sphere *= 1 + t * t;
        sphere /= 2 * w2 * std::sqrt(w2);  // the face's own component gives the factor 2
        const Real support = (a2 * (w[0] * w[0] + w[1] * w[1]) + b2 * w[2] * w[2]) / w2;
        sum += sphere * a2 * a2 * b2 / (support * support);
    };
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells - i; ++j) {
            add((i + Real{1} / 3) / cells, (j + Real{1} / 3) / cells);
            if (i + j + 1 < cells) add((i + Real{2} / 3) / cells, (j + Real{2} / 3) / cells);
        }
    return sum * leg * leg / (2 * cells * cells);
}

TEST(Spacing, ReferenceAreasSumToTheEllipsoids) {
    for (const auto& [name, body] : bodies()) {
        const GeographicLib::Ellipsoid reference(body.a(), (body.a() - body.b()) / body.a());
        for (const int level : {0, 3}) {
            Real sum = 0;
            for (const DiamondId d : all_levels()[static_cast<std::size_t>(level)])
                for (const int side : {0, 1}) sum += area(body, {d, side}, level == 0 ? 80 : 20);
            EXPECT_NEAR(static_cast<double>(sum) / reference.Area(), 1, 1e-3) << name << " level " << level;
        }
    }
}

TEST(Spacing, IsTheRootOfTheMeanCellArea) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const auto& [name, body] : bodies()) {
        std::array<double, kDeepestId + 1> worst{};
        for (int level = 0; level <= kDeepestId; ++level)
            for (int n = 0; n < (level < 12 ? 30 : 10); ++n) {
                const DiamondId d = random_diamond(random, level);
                const int cells = level < 4 ? 40 : level < 12 ? 16 : 4;
                const Real expected = std::sqrt(area(body, {d, 0}, cells) + area(body, {d, 1}, cells)) / 64;
                const double error =
                    std::abs(sample_spacing(body, d, 64) / static_cast<double>(expected) - 1);
                worst[static_cast<std::size_t>(level)] =
                    std::max(worst[static_cast<std::size_t>(level)], error);
            }
        std::cout << name << ", relative error of spacing by level:";
        for (const int level : {0, 1, 2, 4, 8, 12, 20, 50})
            std::cout << "  " << level << ": " << worst[static_cast<std::size_t>(level)];
        std::cout << '\n';
        const double promised = body.b() >= body.a() / 2 ? 0.003 : 0.15;
        for (int level = 0; level <= kDeepestId; ++level)
            EXPECT_LT(worst[static_cast<std::size_t>(level)], promised) << name << " level " << level;
    }
}

TEST(Spacing, OfAllDiamondsOfALevelAddsUpToTheEllipsoid) {
    for (const auto& [name, body] : bodies()) {
        const GeographicLib::Ellipsoid reference(body.a(), (body.a() - body.b()) / body.a());
        for (const int level : {4, 9}) {
            double sum = 0;
            for (const DiamondId d : all_levels()[static_cast<std::size_t>(level)])
                sum += std::pow(64 * sample_spacing(body, d, 64), 2);
            EXPECT_NEAR(sum / reference.Area(), 1, 0.02) << name << " level " << level;
        }
    }
}

}  // namespace
}  // namespace carat::test
