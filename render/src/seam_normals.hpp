// Normals on the edges and corners of patches, from all patches that share them.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "carat/render/patch_mesh.hpp"

namespace carat {

using CodedNormal = std::array<std::int16_t, 2>;  // octahedral

// An edge or corner as a patch has it. Edge 0, 1, 2: a-b, b-x, x-a; corner 0, 1, 2: a, b, x.
struct SeamUse {
    const PatchMesh* mesh = nullptr;
    int part = 0;
};

std::array<LatticePoint, 3> corner_points(const Half& half);
// The midpoint of an edge is the midpoint of no other edge.
std::array<LatticePoint, 3> edge_midpoints(const Half& half);

// Where a patch stores the vertices of an edge, from its lexicographically smaller end on.
class EdgePath {
  public:
    EdgePath(const Half& half, int edge, int cells);
    // t steps from there, 0 <= t <= cells: index into PatchMesh::vertices.
    std::uint32_t operator()(int t) const;

  private:
    int edge_, cells_;
    bool ascending_;
};
std::uint32_t corner_vertex_index(int corner, int cells);

// Normals of the cells - 1 vertices between the ends of an edge, from the lexicographically smaller end on.
// Uses in ascending order of their halves; with one alone, it sees one side only.
void edge_normals(int cells, std::span<const SeamUse> uses, std::span<CodedNormal> out);
CodedNormal corner_normal(int cells, std::span<const SeamUse> uses);

}  // namespace carat
