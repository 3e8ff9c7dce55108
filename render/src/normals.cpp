#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <span>

#include "carat/globe/patch.hpp"
#include "carat/render/octahedral.hpp"
#include "carat/render/patch_builder.hpp"
#include "vector.hpp"

namespace carat {
namespace {

// An edge or a corner of a patch, named by a lattice point: the midpoint of an edge is the midpoint of no
// other edge.
struct Place {
    LatticePoint point;
    std::uint32_t patch = 0;
    int part = 0;  // edge 0, 1, 2: a-b, b-x, x-a; or corner 0, 1, 2: a, b, x

    friend auto operator<=>(const Place&, const Place&) = default;
};

// Vertices in storage order: r >= c, (0, 0) = a, (cells, cells) = b, (cells, 0) = x.
struct Index {
    int r, c;
};
struct Chain {
    std::array<Index, 3> at{};
    int size = 0;
};

Index edge_vertex(int part, int t, int cells) {
    if (part == 0) return {t, t};
    if (part == 1) return {cells, cells - t};
    return {cells - t, 0};
}
Index corner_vertex(int part, int cells) { return edge_vertex(part, 0, cells); }

// The nearest neighbours of a boundary vertex along rows and columns, counter-clockwise in (r, c); at a and
// b, where the half has only one of these, its neighbours along both edges.
Chain edge_neighbours(int part, const Index& v) {
    if (part == 0) return {{{{v.r, v.c - 1}, {v.r + 1, v.c}}}, 2};
    if (part == 1) return {{{{v.r, v.c + 1}, {v.r - 1, v.c}, {v.r, v.c - 1}}}, 3};
    return {{{{v.r + 1, v.c}, {v.r, v.c + 1}, {v.r - 1, v.c}}}, 3};
}
Chain corner_neighbours(int part, const Index& v) {
    if (part == 0) return {{{{1, 0}, {1, 1}}}, 2};
    if (part == 1) return {{{{v.r - 1, v.c - 1}, {v.r, v.c - 1}}}, 2};
    return {{{{v.r, 1}, {v.r - 1, 0}}}, 2};
}

PatchVertex& vertex_at(PatchMesh& mesh, const Index& v) { return mesh.vertices[half_vertex_index(v.r, v.c)]; }

Vec3 relative(const PatchVertex& p, const PatchVertex& origin) {
    Vec3 v{};
    for (std::size_t k = 0; k < 3; ++k) v[k] = static_cast<double>(p.offset[k] - origin.offset[k]);
    return v;
}

// Points around a vertex, relative to it in length units, counter-clockwise seen from outside.
class Ring {
  public:
    void append(PatchMesh& mesh, const Index& vertex, const Chain& chain) {
        for (int k = 0; k < chain.size; ++k) {
            const Index& neighbour =
                chain.at[static_cast<std::size_t>(mesh.half.side == 0 ? k : chain.size - 1 - k)];
            points_[size_++] = relative(vertex_at(mesh, neighbour), vertex_at(mesh, vertex));
        }
    }
    // Twice the area vector; closed: with the triangle from the last point to the first.
    Vec3 area(bool closed) const {
        Vec3 sum{};
        for (std::size_t k = 0; k + 1 < size_; ++k) sum = add(sum, cross(points_[k], points_[k + 1]));
        return closed ? add(sum, cross(points_[size_ - 1], points_[0])) : sum;
    }

  private:
    std::array<Vec3, 6> points_{};
    std::size_t size_ = 0;
};

void set_normal(PatchMesh& mesh, const Index& v, Vec3 normal) {
    PatchVertex& vertex = vertex_at(mesh, v);
    // Heights beyond any planet may fold a ring to nothing: point outwards all the same.
    if (!(dot(normal, normal) > 0))
        for (std::size_t k = 0; k < 3; ++k)
            normal[k] = static_cast<double>(mesh.anchor[k] + vertex.offset[k]);
    vertex.normal = encode_octahedral(normal);
}

std::array<LatticePoint, 3> corner_points(const Half& half) {
    const DiamondCorners d = corners(half.diamond);
    return {d.a, d.b, d.x[static_cast<std::size_t>(half.side)]};
}

LatticePoint midpoint(const LatticePoint& p, const LatticePoint& q) {
    const LatticeVector sum = wide(p) + wide(q);
    return narrow({sum.x / 2, sum.y / 2, sum.z / 2});
}

class Stitch {
  public:
    Stitch(int cells, const std::vector<std::shared_ptr<PatchMesh>>& patches)
        : cells_(cells), patches_(patches) {
        for (std::uint32_t k = 0; k < patches.size(); ++k) {
            const std::array<LatticePoint, 3> p = corner_points(patches[k]->half);
            for (const std::size_t part : {0u, 1u, 2u}) {
                edges_.push_back({midpoint(p[part], p[(part + 1) % 3]), k, static_cast<int>(part)});
                corners_.push_back({p[part], k, static_cast<int>(part)});
            }
        }
        std::sort(edges_.begin(), edges_.end());
        std::sort(corners_.begin(), corners_.end());
    }

    void run() const {
        for_each_group(edges_, [this](std::span<const Place> group) { stitch_edge(group); });
        for_each_group(corners_, [this](std::span<const Place> group) { stitch_corner(group); });
    }

  private:
    // Groups touch distinct vertices.
    template <class Visit>
    void for_each_group(const std::vector<Place>& places, Visit visit) const {
        std::vector<std::size_t> starts;
        for (std::size_t k = 0; k < places.size(); ++k)
            if (k == 0 || places[k].point != places[k - 1].point) starts.push_back(k);
        starts.push_back(places.size());
        tbb::parallel_for(std::size_t{1}, starts.size(), [&](std::size_t k) {
            visit(std::span(places).subspan(starts[k - 1], starts[k] - starts[k - 1]));
        });
    }

    PatchMesh& mesh(const Place& place) const { return *patches_[place.patch]; }

    // Both patches' vertex t steps from the lexicographically smaller end of their common edge.
    Index vertex(const Place& edge, int t) const {
        const std::array<LatticePoint, 3> p = corner_points(mesh(edge).half);
        const auto part = static_cast<std::size_t>(edge.part);
        return edge_vertex(edge.part, p[part] < p[(part + 1) % 3] ? t : cells_ - t, cells_);
    }

    void stitch_edge(std::span<const Place> edge) const {
        for (int t = 1; t < cells_; ++t) {
            Ring ring;
            for (const Place& e : edge) {
                const Index v = vertex(e, t);
                ring.append(mesh(e), v, edge_neighbours(e.part, v));
            }
            const Vec3 normal = ring.area(edge.size() == 2);
            for (const Place& e : edge) set_normal(mesh(e), vertex(e, t), normal);
        }
    }

    void stitch_corner(std::span<const Place> corner) const {
        Vec3 normal{};
        for (const Place& c : corner) {
            Ring ring;
            const Index v = corner_vertex(c.part, cells_);
            ring.append(mesh(c), v, corner_neighbours(c.part, v));
            normal = add(normal, ring.area(false));
        }
        for (const Place& c : corner) set_normal(mesh(c), corner_vertex(c.part, cells_), normal);
    }

    const int cells_;
    const std::vector<std::shared_ptr<PatchMesh>>& patches_;
    std::vector<Place> edges_, corners_;
};

}  // namespace

void stitch_normals(int cells, const std::vector<std::shared_ptr<PatchMesh>>& patches) {
    Stitch(cells, patches).run();
}

}  // namespace carat
