#include "triangle_order.hpp"

#include <meshoptimizer.h>

#include "carat/globe/patch.hpp"

namespace carat {

std::vector<std::uint16_t> drawn_indices(int cells) {
    const std::size_t vertices = half_vertex_count(cells);
    std::vector<std::uint16_t> all;
    for (int side = 0; side < 2; ++side) {
        std::vector<std::uint16_t> indices;
        for (const auto& triangle : half_triangles(side, cells))
            indices.insert(indices.end(), triangle.begin(), triangle.end());
        meshopt_optimizeVertexCache(indices.data(), indices.data(), indices.size(), vertices);
        all.insert(all.end(), indices.begin(), indices.end());
    }
    return all;
}

}  // namespace carat
