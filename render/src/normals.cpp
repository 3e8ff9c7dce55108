#include <tbb/parallel_for.h>

#include <algorithm>
#include <tuple>

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
    int part = 0;  // edge 0, 1, 2 as walked by the boundary slots: a-b, b-x, x-a; or corner 0, 1, 2: a, b, x

    friend auto operator<=>(const Place&, const Place&) = default;
};

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
    Stitch(const PatchTopology& topology, std::vector<BuiltPatch>& patches)
        : topology_(topology), patches_(patches), cells_(static_cast<std::size_t>(topology.cells)) {
        for (std::uint32_t k = 0; k < patches.size(); ++k) {
            const std::array<LatticePoint, 3> p = corner_points(patches[k].mesh->half);
            for (const std::size_t part : {0u, 1u, 2u}) {
                edges_.push_back({midpoint(p[part], p[(part + 1) % 3]), k, static_cast<int>(part)});
                corners_.push_back({p[part], k, static_cast<int>(part)});
            }
        }
        std::sort(edges_.begin(), edges_.end());
        std::sort(corners_.begin(), corners_.end());
    }

    void run() {
        for_each_group(edges_, [this](auto first, auto last) { stitch_edge(first, last); });
        for_each_group(corners_, [this](auto first, auto last) { stitch_corner(first, last); });
    }

  private:
    using Iterator = std::vector<Place>::const_iterator;

    template <class Visit>
    void for_each_group(const std::vector<Place>& places, Visit visit) const {
        std::vector<std::size_t> starts;
        for (std::size_t k = 0; k < places.size(); ++k)
            if (k == 0 || places[k].point != places[k - 1].point) starts.push_back(k);
        starts.push_back(places.size());
        tbb::parallel_for(std::size_t{1}, starts.size(), [&](std::size_t k) {
            visit(places.begin() + static_cast<std::ptrdiff_t>(starts[k - 1]),
                  places.begin() + static_cast<std::ptrdiff_t>(starts[k]));
        });
    }

    // Slot of the vertex t steps along a part, counted from its lexicographically smaller end.
    std::size_t slot(const Place& e, std::size_t t) const {
        const std::array<LatticePoint, 3> p = corner_points(patches_[e.patch].mesh->half);
        const auto part = static_cast<std::size_t>(e.part);
        const bool forwards = p[part] < p[(part + 1) % 3];
        return part * cells_ + (forwards ? t : cells_ - t);
    }

    const Vec3& sum(const Place& place, std::size_t s) const {
        return patches_[place.patch].boundary_normals[s];
    }

    void set(const Place& place, std::size_t s, const Vec3& normal) const {
        PatchMesh& mesh = *patches_[place.patch].mesh;
        PatchVertex& v = mesh.vertices[topology_.boundary[s]];
        Vec3 n = normal;
        if (!(dot(n, n) > 0))
            for (std::size_t k = 0; k < 3; ++k) n[k] = static_cast<double>(mesh.anchor[k] + v.offset[k]);
        v.normal = encode_octahedral(n);
    }

    void stitch_edge(Iterator first, Iterator last) const {
        for (std::size_t t = 1; t < cells_; ++t) {
            Vec3 normal{};
            for (Iterator e = first; e != last; ++e) normal = add(normal, sum(*e, slot(*e, t)));
            for (Iterator e = first; e != last; ++e) set(*e, slot(*e, t), normal);
        }
    }

    void stitch_corner(Iterator first, Iterator last) const {
        const auto corner_slot = [this](const Place& c) { return static_cast<std::size_t>(c.part) * cells_; };
        Vec3 normal{};
        for (Iterator c = first; c != last; ++c) normal = add(normal, sum(*c, corner_slot(*c)));
        for (Iterator c = first; c != last; ++c) set(*c, corner_slot(*c), normal);
    }

    const PatchTopology& topology_;
    std::vector<BuiltPatch>& patches_;
    const std::size_t cells_;
    std::vector<Place> edges_, corners_;
};

}  // namespace

void stitch_normals(const PatchTopology& topology, std::vector<BuiltPatch>& patches) {
    Stitch(topology, patches).run();
}

}  // namespace carat
