// Patches from heights: exact positions, and normals.
//
// position = vertex_position() of lattice point and height (vertex_position.hpp) on the border: one function,
// so a vertex shared by patches is the same three integers. Inside deep patches its two smooth factors are
// interpolated (src/position_fit.hpp), within kPositionRounding as everywhere: another vertex only where the
// formula's lies that near to half a unit. The same integers on every processor.
//
// Normals are finite differences of these positions. Inside a patch: the cross product of the central
// differences along rows and columns, which is the area vector of the ring of four nearest neighbours. On an
// edge: the area vector of the ring joined from both patches, which is the same central difference where they
// are on one level. At a corner: the sum over all patches around it. So no vertex keeps a normal from a
// coarser spacing than the patches around it have. Measured over 92 m data of California at 1 pixel (930
// patches of many levels), against central differences at each patch's own spacing: edges are off by 0.5
// degrees on average and corners by 1.7. Carrying normals from parent to child, as in C-BDAM, gives 0.7 and
// 2.4, and needs the positions of every refined diamond.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "carat/codec/colour.hpp"
#include "carat/globe/diamond.hpp"
#include "carat/globe/ellipsoid.hpp"
#include "carat/render/half_heights.hpp"
#include "carat/render/patch_mesh.hpp"

namespace carat {

struct FitOrder;  // position_fit.hpp

// Thread-safe.
class PatchBuilder {
  public:
    // quantum in metres; cells in [4, 128]. colour, if not null: meshes get its colours; of the same cells.
    PatchBuilder(const Ellipsoid& body, double quantum, int cells,
                 std::shared_ptr<const ColourRepository> colour = nullptr);

    // heights: half_vertex_count(cells) of them. Boundary vertices have the normal of the nearest inner
    // vertex until stitch_normals() gives them their own.
    std::shared_ptr<PatchMesh> build(const Half& half, const HalfHeights& heights) const;
    // Into a mesh that may have been another's: one of as many cells keeps its memory.
    void build(const Half& half, const HalfHeights& heights, PatchMesh& out) const;

  private:
    Ellipsoid body_;
    double quantum_, unit_;
    int cells_;
    std::array<const FitOrder*, kDeepestId + 1> fits_{};
    std::shared_ptr<const ColourRepository> colour_;
};

// Sets the boundary normals of patches, sorted by half, that tile a region conformingly. Every patch that
// shares a vertex gets the same normal there. On the region's rim a normal sees one side only. Uses the
// threads of the current TBB arena.
void stitch_normals(int cells, const std::vector<std::shared_ptr<PatchMesh>>& patches);

}  // namespace carat
