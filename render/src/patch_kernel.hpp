// The inner loops of patch building, in vectors of whatever width the processor has.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "carat/render/half_heights.hpp"
#include "carat/render/patch_mesh.hpp"
#include "position_fit.hpp"
#include "tangent_table.hpp"

namespace carat {

struct PatchShape {
    int cells = 0, side = 0;
    double a2 = 0, b2 = 0;  // squares of the semi-axes, metres^2
    double per_unit = 0;    // length units a metre
    double metres = 0;      // a unit of height
    std::array<const TangentTable*, 3> tangents{};
    UnitVector anchor{};
    const PositionFit* fit = nullptr;  // for vertices inside; null: the formula for all
};

// Fills vertices with offsets from the anchor, heights, and normals by central differences; border vertices
// take the normal of the nearest inner one. heights: half_vertex_count of them, in the file's unit or in
// 2^-kHeightFractionBits of it, as shape.metres says.
void build_vertices(const PatchShape& shape, std::span<const std::int32_t> heights, PatchVertex* vertices);
void build_vertices(const PatchShape& shape, std::span<const std::int64_t> heights, PatchVertex* vertices);

}  // namespace carat
