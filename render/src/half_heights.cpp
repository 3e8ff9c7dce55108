#include "carat/render/half_heights.hpp"

#include <algorithm>
#include <cassert>

#include "carat/globe/patch.hpp"

namespace carat {
namespace {

constexpr std::int64_t kOne = std::int64_t{1} << kHeightFractionBits;

std::size_t matrix_index(int i, int j, int n) { return static_cast<std::size_t>(i * n + j); }

// visit(i, j) in storage order.
template <class Visit>
void visit_half(int side, int cells, Visit visit) {
    for (int r = 0; r <= cells; ++r)
        for (int c = 0; c <= r; ++c) side == 0 ? visit(r, c) : visit(c, r);
}

// height_of(value) for every vertex of the child's half.
template <class Refined, class Widen>
HalfHeights gather(const Refined& parent, DiamondId parent_id, const Half& child_half, Widen widen) {
    const int n = parent.n, cells = n - 1;
    const ChildMap m = child_map(parent_id, child_half, cells);
    HalfHeights out;
    out.reserve(half_vertex_count(cells));
    visit_half(child_half.side, cells, [&](int i, int j) {
        const int p = m.p0 + i * m.pi + j * m.pj, q = m.q0 + i * m.qi + j * m.qj;
        out.push_back(widen((p & 1) == 0 ? parent.v[matrix_index(p >> 1, q >> 1, n)]
                                         : parent.c[matrix_index(p >> 1, q >> 1, cells)]));
    });
    return out;
}

// P as a matrix; both halves hold the diagonal, with equal values.
template <class Value, class Narrow>
std::vector<Value> matrix(const HalfHeights& half0, const HalfHeights& half1, int cells,
                          Narrow narrow_value) {
    const int n = cells + 1;
    std::vector<Value> out(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
    for (const int side : {0, 1}) {
        const HalfHeights& half = side == 0 ? half0 : half1;
        std::size_t k = 0;
        visit_half(side, cells, [&](int i, int j) {
            assert(side == 0 || i != j || out[matrix_index(i, j, n)] == narrow_value(half[k]));
            out[matrix_index(i, j, n)] = narrow_value(half[k++]);
        });
    }
    return out;
}

}  // namespace

std::array<HalfHeights, 2> split(const Heights& root) {
    std::array<HalfHeights, 2> out;
    for (const int side : {0, 1})
        visit_half(side, root.n - 1, [&](int i, int j) {
            out[static_cast<std::size_t>(side)].push_back(root.at(i, j) * kOne);
        });
    return out;
}

Heights whole_heights(const HalfHeights& half0, const HalfHeights& half1, int cells) {
    Heights p;
    p.n = cells + 1;
    p.has_half = {true, true};
    p.values = matrix<std::int32_t>(half0, half1, cells, [](std::int64_t h) {
        assert(h % kOne == 0);
        return static_cast<std::int32_t>(h / kOne);
    });
    return p;
}

HalfHeights gather_child(const RefinedHeights& parent, DiamondId parent_id, const Half& child_half) {
    return gather(parent, parent_id, child_half, [](std::int32_t h) { return h * kOne; });
}

VirtualHeights refine_virtually(const HalfHeights& half0, const HalfHeights& half1, int cells) {
    const int n = cells + 1;
    VirtualHeights out{n, matrix<std::int64_t>(half0, half1, cells, [](std::int64_t h) { return h; }), {}};
    out.c.reserve(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j) {
            const std::int64_t sum =
                main_diagonal(i, j) ? out.v[matrix_index(i, j, n)] + out.v[matrix_index(i + 1, j + 1, n)]
                                    : out.v[matrix_index(i + 1, j, n)] + out.v[matrix_index(i, j + 1, n)];
            assert(sum % 2 == 0);
            out.c.push_back(sum / 2);
        }
    return out;
}

HalfHeights gather_child(const VirtualHeights& parent, DiamondId parent_id, const Half& child_half) {
    return gather(parent, parent_id, child_half, [](std::int64_t h) { return h; });
}

HalfRange half_range(const HalfHeights& heights, int cells, double quantum) {
    const auto [least, greatest] = std::minmax_element(heights.begin(), heights.end());
    std::int64_t range = 0;
    for (int r = 0; r < cells; ++r)
        for (int c = 0; c <= r; ++c) {
            // Corners of the cell whose vertices exist in this half: a triangle where c = r, by symmetry.
            const std::int64_t p = heights[half_vertex_index(r, c)], q = heights[half_vertex_index(r + 1, c)],
                               s = heights[half_vertex_index(r + 1, c + 1)];
            const auto widen = [&range](std::int64_t x, std::int64_t y, std::int64_t z) {
                range = std::max(range, std::max({x, y, z}) - std::min({x, y, z}));
            };
            if (c == r) {
                widen(p, q, s);
                continue;
            }
            const std::int64_t t = heights[half_vertex_index(r, c + 1)];
            if (main_diagonal(r, c)) {
                widen(p, q, s);
                widen(p, s, t);
            } else {
                widen(p, q, t);
                widen(q, s, t);
            }
        }
    const double metres = quantum * kHeightFraction;
    return {static_cast<double>(*least) * metres, static_cast<double>(*greatest) * metres,
            static_cast<double>(range) * metres};
}

}  // namespace carat
