// Culling and screen error are true: checked against points of S and of the drawn triangles, without the
// bounds.
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "carat/globe/locate.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

TEST(Visibility, CulledHalvesHoldNothingVisible) {
    std::mt19937_64 generator(20240101);
    std::array<int, 3> counted{};
    for (const FakeRepository* repository : planets())
        for (const NamedView& v : test_views(*repository, 40, 77)) {
            SCOPED_TRACE(v.name);
            expect_culled_unseen(surface_of(*repository), v.view, cut_of(*repository, v.view, 2.0), generator,
                                 counted);
        }
    EXPECT_GT(counted[static_cast<std::size_t>(Culled::frustum)], 1000);
    EXPECT_GT(counted[static_cast<std::size_t>(Culled::horizon)], 1000);
}

TEST(Visibility, ScreenErrorBoundsWhatIsSeen) {
    std::mt19937_64 generator(4711);
    Seen seen;
    for (const FakeRepository* repository : planets())
        for (const NamedView& v : test_views(*repository, 40, 99)) {
            SCOPED_TRACE(v.name);
            expect_true_errors(surface_of(*repository), v.view, cut_of(*repository, v.view, 3.0), generator,
                               seen);
        }
    EXPECT_GT(seen.tested, 20000u);
    EXPECT_GT(seen.closest, 0.3) << "the bound is lazy";
}

// What is drawn closes the view: no ray that meets the ellipsoid behind which halves are culled slips
// through.
TEST(Visibility, NoRayThatMeetsTheLoweredBodyMissesTheDrawn) {
    std::mt19937_64 generator(8);
    std::uint64_t met = 0;
    for (const FakeRepository* repository : planets())
        for (const double threshold : {1.0, 5.0, 25.0})
            for (const NamedView& v : test_views(*repository, 60, 17)) {
                SCOPED_TRACE(v.name + ", " + std::to_string(threshold) + " pixels");
                const double depth = visibility_of(*repository, v.view, threshold).horizon_depth();
                if (depth >= repository->body().b())
                    continue;  // from so far, so coarse: nothing is lowered to a point
                met += expect_no_hole(repository->body(), 1 - depth / repository->body().b(), v.view,
                                      converged_cut(*repository, v.view, threshold),
                                      repository->header().cells(), generator);
            }
    EXPECT_GT(met, 5000u);
}

// The formula itself against random pairs within delta of each other in a ball.
TEST(Visibility, ScreenErrorHoldsForAnyPairInTheVolume) {
    std::mt19937_64 generator(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    const Ellipsoid body(1000, 1000);
    std::uint64_t tested = 0;
    double closest = 0;
    for (int k = 0; k < 3000; ++k) {
        ViewRequest r;
        r.eye = {90 * unit(generator), 180 * unit(generator)};
        r.height = std::pow(10, 1.5 + 1.5 * unit(generator));
        r.heading = 180 * unit(generator);
        r.pitch = -45 + 45 * unit(generator);
        r.fov = 60 + 50 * unit(generator);
        const View view(body, r);
        const Visibility visibility(view, body, 0, 50, 0);
        // A half somewhere before the eye.
        const Vec3 forward = view.camera().forward;
        Vec3 ahead = view.eye();
        for (std::size_t axis = 0; axis < 3; ++axis)
            ahead[axis] += forward[axis] * (r.height + 20) + 100 * unit(generator);
        const Half half = locate(lattice_position(ahead), 4 + static_cast<int>(generator() % 10)).half;
        const HalfVolume volume = half_volume(body, half, 0, 50, 0);
        const double delta = std::pow(10, 1.2 * unit(generator));
        const double bound = visibility.screen_error(volume, delta);
        for (int m = 0; m < 30; ++m) {
            Vec3 x{}, y{};
            double total = 0;
            for (const Vec3& p : volume.points) {
                const double weight = std::pow(std::abs(unit(generator)), 12);
                total += weight;
                for (std::size_t axis = 0; axis < 3; ++axis) x[axis] += weight * p[axis];
            }
            for (double& c : x) c /= total;
            const Vec3& corner = volume.points[generator() % HalfVolume::kPoints];
            const double away = norm(minus(corner, x));
            if (away == 0) continue;
            for (std::size_t axis = 0; axis < 3; ++axis)
                y[axis] = x[axis] + (corner[axis] - x[axis]) * std::min(1.0, delta / away);
            if (m % 2 == 1) std::swap(x, y);
            if (!on_screen(view, x)) continue;
            const Vec3 p = view.to_screen_axes(x), q = view.to_screen_axes(y);
            if (std::isinf(bound)) continue;
            ASSERT_GT(q[2], 0);
            const double pixels =
                view.focal_pixels() * std::hypot(p[0] / p[2] - q[0] / q[2], p[1] / p[2] - q[1] / q[2]);
            ASSERT_LE(pixels, bound * (1 + 1e-9));
            closest = std::max(closest, pixels / bound);
            ++tested;
        }
    }
    EXPECT_GT(tested, 5000u);
    EXPECT_GT(closest, 0.5) << "the bound is lazy";
}

TEST(Visibility, VolumeHoldsEveryPointOfTheHalf) {
    std::mt19937_64 generator(9);
    std::uniform_real_distribution<double> unit(-1, 1);
    const std::array<Ellipsoid, 2> bodies{Ellipsoid::earth(), Ellipsoid(1000, 700)};
    for (int k = 0; k < 2000; ++k) {
        const Ellipsoid& body = bodies[k % 2];
        const Half half = locate(lattice_position({unit(generator), unit(generator), unit(generator)}),
                                 static_cast<int>(k % 30))
                              .half;
        const double low = -0.01 * body.b() * std::abs(unit(generator)),
                     high = low + 0.02 * body.b() * std::abs(unit(generator));
        const HalfVolume volume = half_volume(body, half, low, high, 0);
        for (int m = 0; m < 40; ++m) {
            const Place place = random_place(half, 4, generator);
            const double height = low + (high - low) * std::abs(unit(generator));
            const Vec3 p = body.position(direction(place.point), height);
            // Inside the hull widened by the slack: no direction separates it.
            Vec3 u{unit(generator), unit(generator), unit(generator)};
            if (m % 2 == 0) u = direction(place.point);
            const double length = norm(u);
            double furthest = -1e300;
            for (const Vec3& q : volume.points)
                furthest = std::max(
                    furthest, (u[0] * (q[0] - p[0]) + u[1] * (q[1] - p[1]) + u[2] * (q[2] - p[2])) / length);
            ASSERT_GE(furthest + volume.slack, -1e-9 * body.a());
        }
    }
}

}  // namespace
}  // namespace carat::test
