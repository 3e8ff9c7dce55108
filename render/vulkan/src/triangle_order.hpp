// The order in which the triangles of a patch are drawn.
#pragma once

#include <cstdint>
#include <vector>

namespace carat {

// Index triples (half_vertex_index) of side 0, then of side 1, cells^2 of each, in an order that suits the
// vertex cache. 16-bit: at most 8385 vertices. The triangle's place within its side is what the device
// numbers it by.
std::vector<std::uint16_t> drawn_indices(int cells);

}  // namespace carat
