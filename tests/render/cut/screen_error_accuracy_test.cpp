// The threshold against an independent ray-caster: rays of the screen are followed to the drawn triangles,
// and to S by marching along its heights; neither knows of bounds, lattices or which patch is wrong by how
// much.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <unordered_map>

#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/draw_list.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

constexpr double kThreshold = 1.5;  // pixels
constexpr double kNothing = std::numeric_limits<double>::infinity();

double dot(const Vec3& p, const Vec3& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; }
Vec3 cross(const Vec3& p, const Vec3& q) {
    return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}
Vec3 along(const Vec3& p, double t, const Vec3& d) {
    return {p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2]};
}

// Distance of a point from a triangle: to its plane inside, else to the nearest side.
double distance(const Vec3& p, const std::array<Vec3, 3>& t) {
    const Vec3 normal = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    const double area = norm(normal);
    bool inside = area > 0;
    double nearest = kNothing;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 side = minus(t[(k + 1) % 3], t[k]), to = minus(p, t[k]);
        inside = inside && dot(cross(side, to), normal) >= 0;
        const double share = std::clamp(dot(to, side) / std::max(dot(side, side), 1e-300), 0.0, 1.0);
        nearest = std::min(nearest, norm(minus(to, {share * side[0], share * side[1], share * side[2]})));
    }
    return inside ? std::abs(dot(minus(p, t[0]), normal)) / area : nearest;
}

// Drawn patches as triangles in metres.
class Drawn {
  public:
    Drawn(const DrawList& list, int cells, double unit) {
        for (const auto& mesh : list.meshes) {
            std::vector<std::array<Vec3, 3>>& out = patches_[mesh->half];
            for (const auto& indices : half_triangles(mesh->half.side, cells)) {
                std::array<Vec3, 3> t{};
                for (std::size_t k = 0; k < 3; ++k)
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        t[k][axis] = unit * static_cast<double>(mesh->anchor[axis] +
                                                                mesh->vertices[indices[k]].offset[axis]);
                out.push_back(t);
            }
        }
    }

    // Where a ray first meets them, in lengths of its direction (Moeller and Trumbore 1997).
    double first_hit(const Vec3& eye, const Vec3& ray) const {
        double first = kNothing;
        for (const auto& [half, triangles] : patches_)
            for (const auto& t : triangles) {
                const Vec3 e1 = minus(t[1], t[0]), e2 = minus(t[2], t[0]), p = cross(ray, e2);
                const double det = dot(e1, p);
                if (det == 0) continue;
                const Vec3 s = minus(eye, t[0]), q = cross(s, e1);
                const double u = dot(s, p) / det, v = dot(ray, q) / det, at = dot(e2, q) / det;
                if (u >= 0 && v >= 0 && u + v <= 1 && at > 0) first = std::min(first, at);
            }
        return first;
    }

    // From a point with this geodetic normal to the patch drawn there; infinite if none is.
    double distance_to(const Vec3& point, const Vec3& normal) const {
        const RealLattice place = lattice_position(normal);
        for (int level = 0; level <= kDeepestId; ++level) {
            const auto it = patches_.find(locate(place, level).half);
            if (it == patches_.end()) continue;
            double nearest = kNothing;
            for (const auto& t : it->second) nearest = std::min(nearest, distance(point, t));
            return nearest;
        }
        return kNothing;
    }

  private:
    std::unordered_map<Half, std::vector<std::array<Vec3, 3>>, HalfHash> patches_;
};

// S as a height over each place.
class HeightField {
  public:
    explicit HeightField(const FakeRepository& repository)
        : repository_(repository), body_(repository.body()) {}

    Vec3 point(const Vec3& normal) const {
        return body_.position(normal, repository_.surface(geodetic(normal)));
    }

    // Metres above S along the geodetic normal, which is given back.
    double above(const Vec3& p, Vec3& normal) const {
        const Ellipsoid::NormalHeight at = body_.normal_height(p);
        normal = at.normal;
        return at.height - repository_.surface(geodetic(at.normal));
    }

    // Where a ray first goes below S, unit direction; infinite if it does not.
    double first_hit(const Vec3& eye, const Vec3& ray) const {
        const double highest = body_.a() + repository_.header().max_height * repository_.header().quantum;
        // Into the ball that holds everything, and out of it.
        const double middle = -dot(eye, ray), square = dot(eye, eye) - middle * middle;
        if (square > highest * highest) return kNothing;
        const double half = std::sqrt(highest * highest - square);
        double before = std::max(0.0, middle - half);
        Vec3 normal{};
        for (double t = before; t <= middle + half;) {
            const double height = above(along(eye, t, ray), normal);
            if (height <= 0) {
                double below = t;
                for (int k = 0; k < 60; ++k) {
                    const double mid = 0.5 * (before + below);
                    (above(along(eye, mid, ray), normal) > 0 ? before : below) = mid;
                }
                return below;
            }
            before = t;
            t += std::max(0.3 * height, 1e-4 * std::max(1.0, t));  // slopes are far below 3
        }
        return kNothing;
    }

    // Distance of a point from S: straight down, then downhill among places around.
    double distance_to(const Vec3& p) const {
        Vec3 best{};
        double nearest = std::abs(above(p, best)), step = nearest / body_.a();
        for (int k = 0; k < 14; ++k, step /= 2) {
            const Vec3 axis = std::abs(best[2]) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
            const Vec3 east = cross(axis, best), north = cross(best, east);
            const Vec3 centre = best;
            for (const auto& [e, n] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
                Vec3 there = along(along(centre, e * step, east), n * step, north);
                const double length = norm(there);
                for (double& x : there) x /= length;
                const double d = norm(minus(p, point(there)));
                if (d < nearest) {
                    nearest = d;
                    best = there;
                }
            }
        }
        return nearest;
    }

  private:
    const FakeRepository& repository_;
    const Ellipsoid& body_;
};

// Pixels that a distance at a point can be seen as: f d sec(theta) / z.
double pixels(const View& view, const Vec3& point, double distance) {
    const Vec3 v = view.to_screen_axes(point);
    return view.focal_pixels() * distance * norm(v) / (v[2] * v[2]);
}

struct Tally {
    std::array<std::uint64_t, 10> bins{};  // by tenths of the threshold
    std::uint64_t count = 0;
    double greatest = 0;  // share of the threshold

    void add(double share) {
        ++count;
        ++bins[static_cast<std::size_t>(std::min(9.0, 10 * share))];
        greatest = std::max(greatest, share);
    }
    void print(const char* what) const {
        std::printf("%s: %llu rays, greatest %.3f of the threshold (overestimated %.2f times); by tenths",
                    what, static_cast<unsigned long long>(count), greatest, 1 / greatest);
        for (const std::uint64_t b : bins) std::printf(" %llu", static_cast<unsigned long long>(b));
        std::printf("\n");
    }
};

TEST(ScreenError, HoldsForEveryRayInBothDirections) {
    std::mt19937_64 generator(17);
    std::uniform_real_distribution<double> unit(-1, 1);
    Tally to_surface, to_drawn;
    int views = 0, beyond_the_deepest = 0;
    for (const FakeRepository* planet : planets()) {
        const HeightField surface(*planet);
        for (const NamedView& v : test_views(*planet, 40, 71)) {
            const DrawList list = converged_cut(*planet, v.view, kThreshold);
            ++views;
            if (list.counters.limited > 0) {
                ++beyond_the_deepest;
                continue;
            }
            const Drawn drawn(list, planet->header().cells(), v.view.unit());
            const Camera& camera = v.view.camera();
            for (int k = 0; k < 16; ++k) {
                const double x = unit(generator) * v.view.tan_x(), y = unit(generator) * v.view.tan_y();
                Vec3 ray = along(along(camera.forward, x, camera.right), y, camera.up);
                const double length = norm(ray);
                for (double& r : ray) r /= length;

                if (const double t = drawn.first_hit(v.view.eye(), ray); t < kNothing) {
                    const Vec3 point = along(v.view.eye(), t, ray);
                    const double error = pixels(v.view, point, surface.distance_to(point));
                    EXPECT_LE(error, kThreshold + 1e-3) << v.name << " drawn at " << x << ", " << y;
                    to_surface.add(error / kThreshold);
                }
                if (const double t = surface.first_hit(v.view.eye(), ray); t < kNothing) {
                    const Vec3 point = along(v.view.eye(), t, ray);
                    Vec3 normal{};
                    (void)surface.above(point, normal);
                    const double error = pixels(v.view, point, drawn.distance_to(point, normal));
                    EXPECT_LE(error, kThreshold + 1e-3) << v.name << " S at " << x << ", " << y;
                    to_drawn.add(std::min(error, 1e9) / kThreshold);
                }
                if (HasFailure()) return;
            }
        }
    }
    to_surface.print("from the drawn to S");
    to_drawn.print("from S to the drawn");
    std::printf("%d views, %d of them beyond the deepest level\n", views, beyond_the_deepest);
    EXPECT_GE(views - beyond_the_deepest, 200);
    EXPECT_GT(to_surface.count, 1500u);
    EXPECT_GT(to_drawn.count, 1500u);
    // A bound that nothing comes near would draw too much.
    EXPECT_GT(to_surface.greatest, 0.3);
}

}  // namespace
}  // namespace carat::test
