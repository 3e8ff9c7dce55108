#include "carat/globe/locate.hpp"
// Culling and screen error are true: checked against points of S and of the drawn triangles, without the
// bounds.
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "carat/globe/bounds.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/draw_list.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

// A random lattice point of a half, and where it is in the half's grid.
struct Place {
    LatticePoint point;
    double x = 0, y = 0;  // index coordinates
};

Place random_place(const Half& half, int cells, std::mt19937_64& generator) {
    // Fractions of a cell that are lattice points at this level.
    const int level = half.diamond.level();
    std::int64_t fraction = std::min<std::int64_t>(256, half_size(level) / cells);
    if (level % 2 == 1) fraction = std::min<std::int64_t>(256, half_size(level) / (2 * cells));
    fraction = std::max<std::int64_t>(1, fraction);
    const HalfFrame fine = half_frame(half, cells * static_cast<int>(fraction));
    std::uniform_int_distribution<std::int64_t> any(0, cells * fraction);
    std::int64_t i = any(generator), j = any(generator);
    if ((i < j) == (half.side == 0) && i != j) std::swap(i, j);
    return {fine.vertex(i, j), static_cast<double>(i) / static_cast<double>(fraction),
            static_cast<double>(j) / static_cast<double>(fraction)};
}

bool on_screen(const View& view, const Vec3& p) {
    const Vec3 v = view.to_screen_axes(p);
    return v[2] > 0 && std::abs(v[0]) <= v[2] * view.tan_x() && std::abs(v[1]) <= v[2] * view.tan_y();
}

// True if the open segment from the eye to p meets the ellipsoid scaled by k, by the quadratic's
// discriminant.
bool hidden(const Ellipsoid& body, double k, const Vec3& eye, const Vec3& p) {
    const Vec3 s{1 / (k * body.a()), 1 / (k * body.a()), 1 / (k * body.b())};
    double dd = 0, de = 0, ee = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double e = s[axis] * eye[axis], d = s[axis] * p[axis] - e;
        dd += d * d;
        de += d * e;
        ee += e * e;
    }
    const double discriminant = de * de - dd * (ee - 1);
    if (discriminant < 0) return false;
    const double t = (-de - std::sqrt(discriminant)) / dd;
    return t > 0 && t < 1;
}

// The least point of S hides at least what the body scaled by 1 + min_height/b does, if that lowers it.
TEST(Visibility, CulledHalvesHoldNothingVisible) {
    std::mt19937_64 generator(20240101);
    std::array<int, 3> counted{};
    for (const FakeRepository* repository : planets()) {
        const RepositoryHeader& header = repository->header();
        const Ellipsoid& body = repository->body();
        const double lowered = 1 + std::min(0.0, header.min_height * header.quantum) / body.b();
        for (const NamedView& v : test_views(*repository, 40, 77)) {
            SCOPED_TRACE(v.name);
            const Cut cut = cut_of(*repository, v.view, 2.0);
            for (const FrontierHalf& f : cut.frontier) {
                ++counted[static_cast<std::size_t>(f.culled)];
                if (f.culled == Culled::none) continue;
                const Half leaf = repository->leaf_above(f.half);
                for (int k = 0; k < 20; ++k) {
                    // S in this half; if the file goes deeper, by the deepest sample below the place.
                    const Place place = random_place(f.half, header.cells(), generator);
                    Half there = leaf;
                    while (repository->refined(there.diamond)) {
                        const auto below = child_halves(there);
                        const HalfFrame frame = half_frame(below[0], 1);
                        const LatticeVector d = wide(place.point) - frame.origin;
                        const auto along = [&](const LatticeVector& axis) {
                            double sum = 0, square = 0;
                            for (int m = 0; m < 3; ++m) {
                                sum += static_cast<double>(d[m]) * static_cast<double>(axis[m]);
                                square += static_cast<double>(axis[m]) * static_cast<double>(axis[m]);
                            }
                            return sum / square;
                        };
                        const double s = along(frame.u), t = along(frame.v);
                        const bool inside =
                            below[0].side == 0 ? t >= 0 && s <= 1 && s >= t : s >= 0 && t <= 1 && t >= s;
                        there = inside ? below[0] : below[1];
                    }
                    const Vec3 p = repository->surface_point(there, place.point);
                    if (f.culled == Culled::frustum)
                        ASSERT_FALSE(on_screen(v.view, p)) << to_string(f.half.diamond);
                    else
                        ASSERT_TRUE(hidden(body, lowered, v.view.eye(), p)) << to_string(f.half.diamond);
                }
            }
        }
    }
    EXPECT_GT(counted[static_cast<std::size_t>(Culled::frustum)], 1000);
    EXPECT_GT(counted[static_cast<std::size_t>(Culled::horizon)], 1000);
}

// Points of drawn triangles against S at the same lattice place, both ways, on screen.
TEST(Visibility, ScreenErrorBoundsWhatIsSeen) {
    std::mt19937_64 generator(4711);
    double closest = 0;
    std::uint64_t tested = 0;
    for (const FakeRepository* repository : planets()) {
        const RepositoryHeader& header = repository->header();
        const int cells = header.cells();
        for (const NamedView& v : test_views(*repository, 40, 99)) {
            SCOPED_TRACE(v.name);
            const Cut cut = cut_of(*repository, v.view, 3.0);
            std::vector<double> error;
            for (const FrontierHalf& f : cut.frontier)
                if (f.culled == Culled::none) error.push_back(f.error);
            const DrawList list = build_draw_list(header, repository->body(), cut);
            ASSERT_EQ(list.meshes.size(), error.size());
            for (std::size_t m = 0; m < list.meshes.size(); ++m) {
                const PatchMesh& mesh = *list.meshes[m];
                const Half leaf = repository->leaf_above(mesh.half);
                if (repository->refined(leaf.diamond)) continue;  // S is finer than this patch: below
                for (int k = 0; k < 10; ++k) {
                    const Place place = random_place(mesh.half, cells, generator);
                    const TriangleWeights w = triangle_weights(place.x, place.y, cells);
                    Vec3 drawn{};
                    for (std::size_t c = 0; c < 3; ++c) {
                        if (w.weight[c] == 0) continue;
                        const PatchVertex& vertex =
                            mesh.vertices[half_vertex_index(w.vertex[c][0], w.vertex[c][1])];
                        for (std::size_t axis = 0; axis < 3; ++axis)
                            drawn[axis] += w.weight[c] * v.view.unit() *
                                           static_cast<double>(mesh.anchor[axis] + vertex.offset[axis]);
                    }
                    const Vec3 truth = repository->surface_point(leaf, place.point);
                    if (!on_screen(v.view, drawn) && !on_screen(v.view, truth)) continue;
                    const Vec3 p = v.view.to_screen_axes(drawn), q = v.view.to_screen_axes(truth);
                    const double pixels = v.view.focal_pixels() *
                                          std::hypot(p[0] / p[2] - q[0] / q[2], p[1] / p[2] - q[1] / q[2]);
                    ASSERT_LE(pixels, error[m] + 1e-6) << to_string(mesh.half.diamond);
                    closest = std::max(closest, pixels / error[m]);
                    ++tested;
                }
            }
        }
    }
    EXPECT_GT(tested, 10000u);
    EXPECT_GT(closest, 0.3) << "the bound is lazy";
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
