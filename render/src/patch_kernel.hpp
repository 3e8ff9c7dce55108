// The inner loops of patch building, in vectors of whatever width the processor has.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "carat/render/half_heights.hpp"
#include "carat/render/patch_mesh.hpp"

namespace carat {

// The tangents of a half's vertices, one lattice coordinate at a time: that of vertex (r, c) in storage order
// is at(r)[c], or *at(r) for all c where the coordinate is the same along a row.
class TangentTable {
  public:
    // The frame of a half with that side and that many cells.
    TangentTable(const HalfFrame& frame, int side, int axis, int cells);

    const double* at(int r) const { return tangents_.data() + first_ + r * per_row_; }
    bool along_row() const { return along_row_; }
    double value(int r, int c) const { return at(r)[along_row_ ? c : 0]; }

  private:
    std::array<double, 2 * 128 + 1 + 31> tangents_;  // padded by a vector's width
    std::ptrdiff_t first_ = 0, per_row_ = 0;
    bool along_row_ = false;
};

// tangents[k] = vertex_tangent(tangents[k]) for a count that is a multiple of 16.
void tangents_in_place(std::span<double> tangents);

struct PatchShape {
    int cells = 0, side = 0;
    double a2 = 0, b2 = 0;  // squares of the semi-axes, metres^2
    double per_unit = 0;    // length units a metre
    double metres = 0;      // a unit of height
    std::array<const TangentTable*, 3> tangents{};
    UnitVector anchor{};
};

// Fills vertices with offsets from the anchor, heights, and normals by central differences; border vertices
// take the normal of the nearest inner one. heights: half_vertex_count of them, in the file's unit or in
// 2^-kHeightFractionBits of it, as shape.metres says.
void build_vertices(const PatchShape& shape, std::span<const std::int32_t> heights, PatchVertex* vertices);
void build_vertices(const PatchShape& shape, std::span<const std::int64_t> heights, PatchVertex* vertices);

}  // namespace carat
