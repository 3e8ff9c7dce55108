#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <span>

#include "carat/globe/patch.hpp"
#include "carat/render/octahedral.hpp"
#include "carat/render/patch_builder.hpp"
#include "carat/render/vector.hpp"
#include "seam_normals.hpp"

namespace carat {
namespace {

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

const PatchVertex& vertex_at(const PatchMesh& mesh, const Index& v) {
    return mesh.vertices[half_vertex_index(v.r, v.c)];
}

Vec3 relative(const PatchVertex& p, const PatchVertex& origin) {
    Vec3 v{};
    for (std::size_t k = 0; k < 3; ++k) v[k] = static_cast<double>(p.offset[k] - origin.offset[k]);
    return v;
}

// Points around a vertex, relative to it in length units, counter-clockwise seen from outside.
class Ring {
  public:
    void append(const PatchMesh& mesh, const Index& vertex, const Chain& chain) {
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

// Heights beyond any planet may fold a ring to nothing: its normal points outwards all the same.
CodedNormal coded(Vec3 normal, const PatchMesh& mesh, const Index& v) {
    if (!(dot(normal, normal) > 0))
        for (std::size_t k = 0; k < 3; ++k)
            normal[k] = static_cast<double>(mesh.anchor[k] + vertex_at(mesh, v).offset[k]);
    return encode_octahedral(normal);
}

LatticePoint midpoint(const LatticePoint& p, const LatticePoint& q) {
    const LatticeVector sum = wide(p) + wide(q);
    return narrow({sum.x / 2, sum.y / 2, sum.z / 2});
}

// Whether t counts from the edge's first end.
bool ascending(const Half& half, int edge) {
    const std::array<LatticePoint, 3> p = corner_points(half);
    const auto part = static_cast<std::size_t>(edge);
    return p[part] < p[(part + 1) % 3];
}

}  // namespace

std::array<LatticePoint, 3> corner_points(const Half& half) {
    const DiamondCorners d = corners(half.diamond);
    return {d.a, d.b, d.x[static_cast<std::size_t>(half.side)]};
}

std::array<LatticePoint, 3> edge_midpoints(const Half& half) {
    const std::array<LatticePoint, 3> p = corner_points(half);
    return {midpoint(p[0], p[1]), midpoint(p[1], p[2]), midpoint(p[2], p[0])};
}

EdgePath::EdgePath(const Half& half, int edge, int cells)
    : edge_(edge), cells_(cells), ascending_(ascending(half, edge)) {}

std::uint32_t EdgePath::operator()(int t) const {
    const Index v = edge_vertex(edge_, ascending_ ? t : cells_ - t, cells_);
    return half_vertex_index(v.r, v.c);
}

std::uint32_t corner_vertex_index(int corner, int cells) {
    const Index v = corner_vertex(corner, cells);
    return half_vertex_index(v.r, v.c);
}

void edge_normals(int cells, std::span<const SeamUse> uses, std::span<CodedNormal> out) {
    std::array<bool, 2> up{};
    for (std::size_t k = 0; k < uses.size(); ++k) up[k] = ascending(uses[k].mesh->half, uses[k].part);
    for (int t = 1; t < cells; ++t) {
        Ring ring;
        Index v{};
        for (std::size_t k = 0; k < uses.size(); ++k) {
            v = edge_vertex(uses[k].part, up[k] ? t : cells - t, cells);
            ring.append(*uses[k].mesh, v, edge_neighbours(uses[k].part, v));
        }
        out[static_cast<std::size_t>(t - 1)] = coded(ring.area(uses.size() == 2), *uses.back().mesh, v);
    }
}

CodedNormal corner_normal(int cells, std::span<const SeamUse> uses) {
    Vec3 normal{};
    Index v{};
    for (const SeamUse& use : uses) {
        Ring ring;
        v = corner_vertex(use.part, cells);
        ring.append(*use.mesh, v, corner_neighbours(use.part, v));
        normal = add(normal, ring.area(false));
    }
    return coded(normal, *uses.back().mesh, v);
}

namespace {

// An edge or corner of a patch, named by its midpoint or place.
struct Place {
    LatticePoint point;
    std::uint32_t patch = 0;
    int part = 0;

    friend auto operator<=>(const Place&, const Place&) = default;
};

class Stitch {
  public:
    Stitch(int cells, const std::vector<std::shared_ptr<PatchMesh>>& patches)
        : cells_(cells), patches_(patches) {
        for (std::uint32_t k = 0; k < patches.size(); ++k) {
            const std::array<LatticePoint, 3> ends = corner_points(patches[k]->half),
                                              middles = edge_midpoints(patches[k]->half);
            for (const int part : {0, 1, 2}) {
                edges_.push_back({middles[static_cast<std::size_t>(part)], k, part});
                corners_.push_back({ends[static_cast<std::size_t>(part)], k, part});
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

    std::vector<SeamUse> uses(std::span<const Place> group) const {
        std::vector<SeamUse> out;
        for (const Place& p : group) out.push_back({patches_[p.patch].get(), p.part});
        return out;
    }

    void stitch_edge(std::span<const Place> edge) const {
        std::vector<CodedNormal> normals(static_cast<std::size_t>(cells_ - 1));
        edge_normals(cells_, uses(edge), normals);
        for (const Place& e : edge) {
            PatchMesh& mesh = *patches_[e.patch];
            const EdgePath path(mesh.half, e.part, cells_);
            for (int t = 1; t < cells_; ++t)
                mesh.vertices[path(t)].normal = normals[static_cast<std::size_t>(t - 1)];
        }
    }

    void stitch_corner(std::span<const Place> corner) const {
        const CodedNormal normal = corner_normal(cells_, uses(corner));
        for (const Place& c : corner)
            patches_[c.patch]->vertices[corner_vertex_index(c.part, cells_)].normal = normal;
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
