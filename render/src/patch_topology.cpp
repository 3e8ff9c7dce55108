#include "carat/render/patch_topology.hpp"

#include <algorithm>

#include "carat/globe/patch.hpp"

namespace carat {

PatchTopology::PatchTopology(int cell_count) : cells(cell_count) {
    boundary_slot.assign(half_vertex_count(cells), kInterior);
    const auto add = [this](int r, int c) {
        const auto vertex = static_cast<std::uint16_t>(half_vertex_index(r, c));
        boundary_slot[vertex] = static_cast<std::uint16_t>(boundary.size());
        boundary.push_back(vertex);
    };
    for (int t = 0; t < cells; ++t) add(t, t);              // a to b
    for (int t = 0; t < cells; ++t) add(cells, cells - t);  // b to x
    for (int t = 0; t < cells; ++t) add(cells - t, 0);      // x to a
    for (const int side : {0, 1})
        for (const auto& t : half_triangles(side, cells))
            if (std::any_of(t.begin(), t.end(),
                            [&](std::uint16_t v) { return boundary_slot[v] != kInterior; }))
                rim[static_cast<std::size_t>(side)].push_back(t);
}

}  // namespace carat
