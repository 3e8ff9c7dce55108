#include "render/cut/checks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "carat/globe/patch.hpp"

namespace carat::test {
namespace {

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

std::vector<LatticePoint> edge_points(const Half& half, int cells, int edge) {
    std::vector<LatticePoint> points;
    for (int t = 0; t <= cells; ++t)
        points.push_back(edge == 0   ? lattice_vertex(half, cells, t, t)
                         : edge == 1 ? lattice_vertex(half, cells, t, 0)
                                     : lattice_vertex(half, cells, cells, t));
    return points;
}

Vec3 drawn_point(const PatchMesh& mesh, const Place& place, int cells, double unit) {
    const TriangleWeights w = triangle_weights(place.x, place.y, cells);
    Vec3 p{};
    for (std::size_t c = 0; c < 3; ++c) {
        if (w.weight[c] == 0) continue;
        const PatchVertex& vertex = mesh.vertices[half_vertex_index(w.vertex[c][0], w.vertex[c][1])];
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] += w.weight[c] * unit * static_cast<double>(mesh.anchor[axis] + vertex.offset[axis]);
    }
    return p;
}

// True if the ray (x, y, 1) of the screen's axes meets a triangle of the patch. A triangle before the eye is
// met if the ray passes its three sides on one side; sides that patches share give both the same sign.
bool ray_meets(const PatchMesh& mesh, const View& view, double x, double y, int cells) {
    std::vector<Vec3> v;
    v.reserve(mesh.vertices.size());
    for (const PatchVertex& vertex : mesh.vertices) {
        Vec3 p{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] = view.unit() * static_cast<double>(mesh.anchor[axis] + vertex.offset[axis] -
                                                        view.camera().eye[axis]) +
                      view.eye()[axis];
        const Vec3 s = view.to_screen_axes(p);
        v.push_back({s[0] - x * s[2], s[1] - y * s[2], s[2]});  // sheared: the ray is the z axis
    }
    for (const auto& t : half_triangles(mesh.half.side, cells)) {
        const Vec3 &p = v[t[0]], &q = v[t[1]], &r = v[t[2]];
        const double pq = p[0] * q[1] - p[1] * q[0], qr = q[0] * r[1] - q[1] * r[0],
                     rp = r[0] * p[1] - r[1] * p[0];
        const bool inside = (pq >= 0 && qr >= 0 && rp >= 0) || (pq <= 0 && qr <= 0 && rp <= 0);
        if (!inside || pq + qr + rp == 0) continue;
        if ((qr * p[2] + rp * q[2] + pq * r[2]) / (pq + qr + rp) > 0) return true;
    }
    return false;
}

}  // namespace

std::uint64_t expect_no_hole(const Ellipsoid& body, double scale, const View& view, const DrawList& list,
                             int cells, std::mt19937_64& generator) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::uint64_t met = 0;
    for (int k = 0; k < 40; ++k) {
        const double x = unit(generator) * view.tan_x(), y = unit(generator) * view.tan_y();
        const Camera& camera = view.camera();
        Vec3 far{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            far[axis] = view.eye()[axis] +
                        1e9 * (camera.forward[axis] + x * camera.right[axis] + y * camera.up[axis]);
        if (!hidden(body, scale, view.eye(), far)) continue;
        ++met;
        EXPECT_TRUE(std::any_of(list.meshes.begin(), list.meshes.end(),
                                [&](const auto& mesh) { return ray_meets(*mesh, view, x, y, cells); }))
            << "a ray through " << x / view.tan_x() << ", " << y / view.tan_y() << " misses everything";
    }
    return met;
}

namespace {

// Depth along the view axis at which the ray (x, y, 1) of the screen's axes first meets a list; infinite if
// never.
double first_depth(const DrawList& list, const View& view, double x, double y, int cells) {
    double first = std::numeric_limits<double>::infinity();
    for (const auto& mesh : list.meshes) {
        std::vector<Vec3> v;
        for (const PatchVertex& vertex : mesh->vertices) {
            Vec3 p{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                p[axis] = view.unit() * static_cast<double>(mesh->anchor[axis] + vertex.offset[axis] -
                                                            view.camera().eye[axis]) +
                          view.eye()[axis];
            v.push_back(view.to_screen_axes(p));
        }
        for (const auto& t : half_triangles(mesh->half.side, cells)) {
            const Vec3 &p = v[t[0]], &q = v[t[1]], &r = v[t[2]];
            // Volumes with the ray; all of one sign inside.
            const auto volume = [&](const Vec3& s, const Vec3& e) {
                return x * (s[1] * e[2] - s[2] * e[1]) + y * (s[2] * e[0] - s[0] * e[2]) +
                       (s[0] * e[1] - s[1] * e[0]);
            };
            const double a = volume(q, r), b = volume(r, p), c = volume(p, q), sum = a + b + c;
            if (sum == 0 || a / sum < 0 || b / sum < 0 || c / sum < 0) continue;
            const double depth = (a * p[2] + b * q[2] + c * r[2]) / sum;
            if (depth > 0) first = std::min(first, depth);
        }
    }
    return first;
}

}  // namespace

std::uint64_t expect_behind(const DrawList& drawn, const DrawList& hidden, const View& view, int cells,
                            std::mt19937_64& generator) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::uint64_t met = 0;
    for (int k = 0; k < 20; ++k) {
        const double x = unit(generator) * view.tan_x(), y = unit(generator) * view.tan_y();
        const double before = first_depth(drawn, view, x, y, cells);
        const double behind = first_depth(hidden, view, x, y, cells);
        if (std::isfinite(before) || std::isfinite(behind)) ++met;
        EXPECT_TRUE(!std::isfinite(behind) || before < behind)
            << "a culled patch is seen at " << x << ", " << y;
    }
    return met;
}

LatticePoint lattice_vertex(const Half& half, int cells, int r, int c) {
    const HalfFrame f = half_frame(half, cells);
    return half.side == 0 ? f.vertex(r, c) : f.vertex(c, r);
}

bool on_screen(const View& view, const Vec3& p) {
    const Vec3 v = view.to_screen_axes(p);
    return v[2] > 0 && std::abs(v[0]) <= v[2] * view.tan_x() && std::abs(v[1]) <= v[2] * view.tan_y();
}

Place random_place(const Half& half, int cells, std::mt19937_64& generator) {
    // Fractions of a cell that are lattice points at this level.
    const std::int64_t fraction = std::clamp<std::int64_t>(half_size(half.diamond.level()) / cells, 1, 256);
    const HalfFrame fine = half_frame(half, cells * static_cast<int>(fraction));
    std::uniform_int_distribution<std::int64_t> any(0, cells * fraction);
    std::int64_t i = any(generator), j = any(generator);
    if (half.side == 0 ? i < j : i > j) std::swap(i, j);
    return {fine.vertex(i, j), static_cast<double>(i) / static_cast<double>(fraction),
            static_cast<double>(j) / static_cast<double>(fraction)};
}

void expect_conforming(const Cut& cut) {
    std::map<std::pair<LatticePoint, LatticePoint>, int> uses;
    for (const FrontierHalf& f : cut.frontier) {
        const DiamondCorners c = corners(f.half.diamond);
        const LatticePoint x = c.x[static_cast<std::size_t>(f.half.side)];
        for (const auto& [p, q] : {std::pair{c.a, c.b}, std::pair{c.a, x}, std::pair{x, c.b}})
            ++uses[std::minmax(p, q)];
    }
    for (const auto& [edge, count] : uses) ASSERT_EQ(count, 2);
    EXPECT_EQ(uses.size() * 2, cut.frontier.size() * 3);
}

std::uint64_t expect_watertight(const DrawList& list, int cells, bool normals) {
    struct Vertex {
        UnitVector position{};
        std::array<std::int16_t, 2> normal{};
        float height = 0;
        int patches = 0;
    };
    std::map<LatticePoint, Vertex> vertices;
    std::map<LatticePoint, int> edges;  // midpoint -> drawn patches
    std::uint64_t again = 0;
    for (const auto& mesh : list.meshes) {
        std::size_t k = 0;
        for (int r = 0; r <= cells; ++r)
            for (int c = 0; c <= r; ++c, ++k) {
                if (c > 0 && c < r && r < cells) continue;  // of no other patch: the edges of halves tile
                const PatchVertex& v = mesh->vertices[k];
                const UnitVector position{mesh->anchor[0] + v.offset[0], mesh->anchor[1] + v.offset[1],
                                          mesh->anchor[2] + v.offset[2]};
                Vertex& seen = vertices[lattice_vertex(mesh->half, cells, r, c)];
                if (seen.patches++ == 0) {
                    seen.position = position;
                    seen.normal = v.normal;
                    seen.height = v.height;
                    continue;
                }
                ++again;
                EXPECT_EQ(seen.position, position) << to_string(mesh->half.diamond);
                EXPECT_TRUE(!normals || seen.normal == v.normal) << to_string(mesh->half.diamond);
                EXPECT_EQ(seen.height, v.height) << to_string(mesh->half.diamond);
                if (testing::Test::HasFailure()) return again;
            }
        for (const int edge : {0, 1, 2})
            ++edges[edge_points(mesh->half, cells, edge)[static_cast<std::size_t>(cells / 2)]];
    }
    for (const auto& mesh : list.meshes)
        for (const int edge : {0, 1, 2}) {
            const std::vector<LatticePoint> points = edge_points(mesh->half, cells, edge);
            const int users = edges.at(points[static_cast<std::size_t>(cells / 2)]);
            EXPECT_LE(users, 2);
            for (std::size_t t = 1; t + 1 < points.size(); ++t)
                EXPECT_EQ(vertices.at(points[t]).patches, users) << "a vertex that one side lacks";
        }
    return again;
}

void expect_true_errors(const TrueSurface& surface, const View& view, const Cut& cut,
                        std::mt19937_64& generator, Seen& seen) {
    const int cells = surface.header.cells();
    std::vector<double> error;
    for (const FrontierHalf& f : cut.frontier)
        if (f.culled == Culled::none) error.push_back(f.error);
    const DrawList list = build_draw_list(surface.header, surface.body, cut);
    ASSERT_EQ(list.meshes.size(), error.size());
    for (std::size_t m = 0; m < list.meshes.size(); ++m)
        for (int k = 0; k < 10; ++k) {
            const PatchMesh& mesh = *list.meshes[m];
            const Place place = random_place(mesh.half, cells, generator);
            const Vec3 drawn = drawn_point(mesh, place, cells, view.unit());
            const Vec3 truth = surface.point(mesh.half, place.point);
            if (!on_screen(view, drawn) && !on_screen(view, truth)) continue;
            const Vec3 p = view.to_screen_axes(drawn), q = view.to_screen_axes(truth);
            const double pixels =
                view.focal_pixels() * std::hypot(p[0] / p[2] - q[0] / q[2], p[1] / p[2] - q[1] / q[2]);
            ASSERT_LE(pixels, error[m] + 1e-6) << to_string(mesh.half.diamond);
            seen.closest = std::max(seen.closest, pixels / error[m]);
            ++seen.tested;
        }
}

void expect_culled_unseen(const TrueSurface& surface, const View& view, const Cut& cut,
                          std::mt19937_64& generator, std::array<int, 3>& counted) {
    // The body scaled by 1 + min_height / b lies below all of S, if that lowers it.
    const double scale =
        1 + std::min(0.0, surface.header.min_height * surface.header.quantum) / surface.body.b();
    for (const FrontierHalf& f : cut.frontier) {
        ++counted[static_cast<std::size_t>(f.culled)];
        if (f.culled == Culled::none) continue;
        for (int k = 0; k < 20; ++k) {
            const Vec3 p =
                surface.point(f.half, random_place(f.half, surface.header.cells(), generator).point);
            if (f.culled == Culled::frustum)
                ASSERT_FALSE(on_screen(view, p)) << to_string(f.half.diamond);
            else
                ASSERT_TRUE(hidden(surface.body, scale, view.eye(), p)) << to_string(f.half.diamond);
        }
    }
}

}  // namespace carat::test
