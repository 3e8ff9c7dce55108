// How rough a leaf is around each of its vertices.
//
// sigma^2(s) is the mean square of h - (h' + h'')/2 over vertices with neighbours h', h'' at distance s along
// a row or column. Relief whose spectrum is a power law has sigma^2(s) ~ s^2H. Sigma is that of
// s = 1 cell, H comes from it and s = 4; the first residual below the leaf is one of s = 1/sqrt(2) cells.
//
// Inside a half these are means over blocks, interpolated. On its three edges they come from the heights on
// that edge alone, which both neighbours have, and near an edge they blend: so roughness is continuous from
// half to half and no neighbour is read. A vertex whose neighbours are all as high as it is level: none.
#pragma once

#include <cstdint>
#include <span>

namespace carat {

// heights: half_vertex_count(cells) of them, quanta, in storage order; factor: added to every amplitude;
// greatest: of amplitudes; both log2 in 1/256. out: packed (detail_code.hpp).
void estimate_roughness(std::span<const std::int32_t> heights, int cells, int factor, int greatest,
                        std::span<std::int32_t> out);

}  // namespace carat
