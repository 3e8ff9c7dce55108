#include "carat/globe/patch.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace carat {
namespace {

using Triangle = std::array<std::uint16_t, 3>;

std::uint16_t index16(int i, int j) { return static_cast<std::uint16_t>(half_vertex_index(i, j)); }

// Both triangles of a whole cell, counter-clockwise (i to the right, j up).
void add_cell(std::vector<Triangle>& out, int i, int j) {
    if (main_diagonal(i, j)) {
        out.push_back({index16(i, j), index16(i + 1, j), index16(i + 1, j + 1)});
        out.push_back({index16(i, j), index16(i + 1, j + 1), index16(i, j + 1)});
    } else {
        out.push_back({index16(i, j), index16(i + 1, j), index16(i, j + 1)});
        out.push_back({index16(i + 1, j), index16(i + 1, j + 1), index16(i, j + 1)});
    }
}

}  // namespace

std::vector<Triangle> half_triangles(int side, int cells) {
    assert(cells > 0 && cells <= 128);
    std::vector<Triangle> out;
    out.reserve(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
    for (int r = 0; r < cells; ++r) {
        for (int c = 0; c < r; ++c) side == 0 ? add_cell(out, r, c) : add_cell(out, c, r);
        if (side == 0)
            out.push_back({index16(r, r), index16(r + 1, r), index16(r + 1, r + 1)});
        else
            out.push_back({index16(r, r), index16(r + 1, r + 1), index16(r, r + 1)});
    }
    return out;
}

TriangleWeights triangle_weights(double x, double y, int cells) {
    const int i = std::clamp(static_cast<int>(std::floor(x)), 0, cells - 1);
    const int j = std::clamp(static_cast<int>(std::floor(y)), 0, cells - 1);
    const double fx = std::clamp(x - i, 0.0, 1.0), fy = std::clamp(y - j, 0.0, 1.0);
    if (main_diagonal(i, j)) {
        if (fx >= fy) return {{{{i, j}, {i + 1, j}, {i + 1, j + 1}}}, {1 - fx, fx - fy, fy}};
        return {{{{i, j}, {i + 1, j + 1}, {i, j + 1}}}, {1 - fy, fx, fy - fx}};
    }
    const double gx = 1 - fx;  // fx + fy may round to 1 from either side: compare fy with gx, once rounded
    if (fy <= gx) return {{{{i, j}, {i + 1, j}, {i, j + 1}}}, {gx - fy, fx, fy}};
    return {{{{i + 1, j}, {i + 1, j + 1}, {i, j + 1}}}, {1 - fy, fy - gx, gx}};
}

}  // namespace carat
