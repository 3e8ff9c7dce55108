// Connectivity of patches: the 4-8 pattern, shared by codec, render and their tests.
//
// A half of cells = N - 1 = 2^p cells a side has N(N+1)/2 vertices and cells^2 triangles. A cell (i, j) is
// split by the diagonal through its vertex with both indices odd; so every coarse triangle is exactly a union
// of finer ones, and each refined cell centre (the midpoint of that diagonal) lies on a coarse edge.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace carat {

// Vertices of a half in storage order: rows of the index along the leg from a, i.e. side 0: for i = 0..cells,
// j = 0..i; side 1: for j = 0..cells, i = 0..j. index = r(r+1)/2 + c with r = max(i, j), c = min(i, j).
constexpr std::uint32_t half_vertex_count(int cells) {
    return static_cast<std::uint32_t>((cells + 1) * (cells + 2) / 2);
}
constexpr std::uint32_t half_vertex_index(int i, int j) {
    const int r = i > j ? i : j;
    const int c = i > j ? j : i;
    return static_cast<std::uint32_t>(r * (r + 1) / 2 + c);
}

// True if the diagonal of cell (i, j) runs from (i, j) to (i+1, j+1); false: from (i+1, j) to (i, j+1).
// The vertex with both indices odd: (i, j) if both odd, (i+1, j+1) if both even, else on the anti-diagonal.
constexpr bool main_diagonal(int i, int j) { return ((i ^ j) & 1) == 0; }

// Triangles of a half (side 0 or 1) as triples of half_vertex_index, counter-clockwise seen from outside.
// cells^2 triangles, in scan order. cells <= 128.
std::vector<std::array<std::uint16_t, 3>> half_triangles(int side, int cells);

// Linear interpolation weights of the 4-8 triangle that contains index position (x, y), 0 <= x, y <= cells.
struct TriangleWeights {
    std::array<std::array<int, 2>, 3> vertex{};  // (i, j) of the corners
    std::array<double, 3> weight{};              // sum 1, each >= 0
};
TriangleWeights triangle_weights(double x, double y, int cells);

}  // namespace carat
