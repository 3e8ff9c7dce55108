// The vertices of a patch that it shares with others: its three edges.
//
//   edge 0  the longest, a - b      edge 1  the leg a - x      edge 2  the leg x - b
//
// (the numbering of carat::neighbour). In storage order (r, c), c <= r: edge 0 is c = r, edge 1 is c = 0,
// edge 2 is r = cells; the same in both sides. Boundary slots number the 3 * cells boundary vertices: slot e
// * cells + t is vertex t of edge e, counted along the way a - b, b - x, x - a; so the corners a, b, x are
// slots 0, cells, 2 cells.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace carat {

struct PatchTopology {
    int cells = 0;
    std::vector<std::uint16_t> boundary;       // slot -> vertex
    std::vector<std::uint16_t> boundary_slot;  // vertex -> slot, or kInterior
    // Triangles that touch the boundary, by side, in scan order.
    std::array<std::vector<std::array<std::uint16_t, 3>>, 2> rim;

    static constexpr std::uint16_t kInterior = 0xFFFF;

    // cells in [2, 128].
    explicit PatchTopology(int cells);
    int slots() const { return 3 * cells; }
};

}  // namespace carat
