// The inner loops over the heights of halves, in vectors of whatever width the processor has.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "carat/globe/ellipsoid.hpp"

namespace carat {

// Sixteen places: three coordinates of each, one coordinate at a time.
using Places = std::array<std::array<double, 16>, 3>;
// direction_from_tangents(w), and the ellipsoid's position() there at height 0; metres.
void normals_and_ground(const Ellipsoid& body, const Places& w, Places& normals, Places& ground);

// Of the heights of a half: the least, the greatest, and the greatest range within one triangle.
struct WholeRange {
    std::int32_t least = 0, greatest = 0;
    std::uint32_t in_triangle = 0;
};
WholeRange whole_range(std::span<const std::int32_t> heights, int cells);

// out[i * (cells + 1) + j] = the half's value at row j and column i, i <= j.
void transpose_half(std::span<const std::int32_t> half, int cells, std::int32_t* out);

// Doubled indices of a parent's refined grid, as in ChildMap, of a child's vertex at row r, column c: p = p0
// + r p_row + c p_along, q likewise; each step is 1 or -1.
struct RowMap {
    int p0, q0, p_row, q_row, p_along, q_along;
};
// out: half_vertex_count(cells) values from V and C, (cells + 1)^2 and cells^2 of them.
void gather_rows(const std::int32_t* v, const std::int32_t* c, const RowMap& map, int cells,
                 std::int32_t* out);

}  // namespace carat
