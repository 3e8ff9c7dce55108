// Patches from heights: exact positions, and normals.
//
// position = to_units(Ellipsoid::position(direction(lattice point), height)): one function of (lattice point,
// height), so a vertex shared by patches is the same three integers. Normals inside a patch are central
// differences of its positions. On the boundary they are the area-weighted sum of the normals of all
// triangles around the vertex in every patch of the list, added in the order of halves: stitch_normals().
#pragma once

#include <memory>
#include <vector>

#include "carat/globe/ellipsoid.hpp"
#include "carat/render/half_heights.hpp"
#include "carat/render/patch_mesh.hpp"
#include "carat/render/patch_topology.hpp"

namespace carat {

struct BuiltPatch {
    std::shared_ptr<PatchMesh> mesh;
    // For each boundary slot: twice the area-weighted sum of the normals of this patch's triangles around it,
    // square length units.
    std::vector<Vec3> boundary_normals;
};

// Thread-safe.
class PatchBuilder {
  public:
    // quantum in metres; cells in [4, 128].
    PatchBuilder(const Ellipsoid& body, double quantum, int cells);

    const PatchTopology& topology() const { return topology_; }

    // heights: half_vertex_count(cells) of them.
    BuiltPatch build(const Half& half, const HalfHeights& heights) const;

  private:
    Ellipsoid body_;
    double quantum_, unit_;
    PatchTopology topology_;
};

// Completes the boundary normals of patches that tile a region conformingly, sorted by half. Every patch that
// shares a vertex gets the same normal there. Uses the threads of the current TBB arena.
void stitch_normals(const PatchTopology& topology, std::vector<BuiltPatch>& patches);

}  // namespace carat
