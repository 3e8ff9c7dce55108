#include "carat/render/half_heights.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdlib>

#include "carat/globe/patch.hpp"
#include "half_kernel.hpp"

namespace carat {
namespace {

std::size_t matrix_index(int i, int j, int n) { return static_cast<std::size_t>(i * n + j); }

RowMap row_map(DiamondId parent_id, const Half& child_half, int cells) {
    const ChildMap m = child_map(parent_id, child_half, cells);
    const bool straight = child_half.side == 0;  // r is i, c is j
    const RowMap rows =
        straight ? RowMap{m.p0, m.q0, m.pi, m.qi, m.pj, m.qj} : RowMap{m.p0, m.q0, m.pj, m.qj, m.pi, m.qi};
    assert(std::abs(rows.p_row) == 1 && std::abs(rows.q_row) == 1 && std::abs(rows.p_along) == 1 &&
           std::abs(rows.q_along) == 1);
    return rows;
}

// gather_rows() of heights with fractions.
void gather_rows(const std::int64_t* v, const std::int64_t* c, const RowMap& m, int cells,
                 std::int64_t* row) {
    const int n = cells + 1;
    const std::ptrdiff_t v_step = m.p_along * n + m.q_along, c_step = m.p_along * cells + m.q_along;
    for (int r = 0; r <= cells; row += ++r) {
        // The first even and the first odd place along the row; floor of the halves.
        const int p = m.p0 + r * m.p_row, q = m.q0 + r * m.q_row, next_p = p + m.p_along,
                  next_q = q + m.q_along;
        const bool v_first = (p & 1) == 0;
        const int vp = v_first ? p : next_p, vq = v_first ? q : next_q;
        const int cp = v_first ? next_p : p, cq = v_first ? next_q : q;
        std::ptrdiff_t at_v = (vp >> 1) * n + (vq >> 1), at_c = (cp >> 1) * cells + (cq >> 1);
        int k = 0;
        if (!v_first) {
            row[k++] = c[at_c];
            at_c += c_step;
        }
        for (; k < r; k += 2, at_v += v_step, at_c += c_step) {
            row[k] = v[at_v];
            row[k + 1] = c[at_c];
        }
        if (k == r) row[k] = v[at_v];
    }
}

// The child's half in storage order.
template <class Value>
std::vector<Value, BlockAllocator<Value>> gather(const Value* v, const Value* c, DiamondId parent_id,
                                                 const Half& child_half, int cells) {
    std::vector<Value, BlockAllocator<Value>> out(half_vertex_count(cells));
    gather_rows(v, c, row_map(parent_id, child_half, cells), cells, out.data());
    return out;
}

// P as a matrix; both halves hold the diagonal, with equal values.
template <class Half0, class Half1, class Value>
void fill_matrix(const Half0& half0, const Half1& half1, int cells, Value* out) {
    const int n = cells + 1;
    std::size_t k = 0;
    for (int i = 0; i <= cells; ++i)
        for (int j = 0; j <= i; ++j, ++k) out[matrix_index(i, j, n)] = half0(k);
    k = 0;
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= j; ++i, ++k) out[matrix_index(i, j, n)] = half1(k);
}

}  // namespace

std::array<HalfHeights, 2> split(const Heights& root) {
    std::array<HalfHeights, 2> out;
    for (int r = 0; r < root.n; ++r)
        for (int c = 0; c <= r; ++c) {
            out[0].whole.push_back(root.at(r, c));
            out[1].whole.push_back(root.at(c, r));
        }
    return out;
}

void whole_heights(const HalfHeights& half0, const HalfHeights& half1, int cells, Heights& out) {
    assert(!half0.whole.empty() && !half1.whole.empty());
    out.n = cells + 1;
    out.has_half = {true, true};
    out.values.resize(static_cast<std::size_t>(out.n) * static_cast<std::size_t>(out.n));
    const std::int32_t* row = half0.whole.data();
    for (int i = 0; i <= cells; row += ++i) std::copy_n(row, i + 1, &out.values[matrix_index(i, 0, out.n)]);
    transpose_half(half1.whole, cells, out.values.data());
}

HalfHeights gather_child(const RefinedHeights& parent, DiamondId parent_id, const Half& child_half) {
    return {gather(parent.v.data(), parent.c.data(), parent_id, child_half, parent.n - 1), {}};
}

void virtual_vertices(const HalfHeights& half0, const HalfHeights& half1, int cells, std::int64_t* out) {
    if (half0.whole.empty() && half1.whole.empty())
        fill_matrix([p = half0.fine.data()](std::size_t k) { return p[k]; },
                    [p = half1.fine.data()](std::size_t k) { return p[k]; }, cells, out);
    else
        fill_matrix([&](std::size_t k) { return half0.at(k); }, [&](std::size_t k) { return half1.at(k); },
                    cells, out);
}

VirtualHeights refine_virtually(const HalfHeights& half0, const HalfHeights& half1, int cells) {
    const int n = cells + 1;
    VirtualHeights out;
    out.n = n;
    out.v.resize(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
    virtual_vertices(half0, half1, cells, out.v.data());
    out.c.reserve(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j) {
            const std::int64_t sum =
                main_diagonal(i, j) ? out.v[matrix_index(i, j, n)] + out.v[matrix_index(i + 1, j + 1, n)]
                                    : out.v[matrix_index(i + 1, j, n)] + out.v[matrix_index(i, j + 1, n)];
            out.c.push_back(sum >> 1);
        }
    return out;
}

HalfHeights gather_child(const VirtualHeights& parent, DiamondId parent_id, const Half& child_half) {
    HalfHeights out{{}, gather(parent.v.data(), parent.c.data(), parent_id, child_half, parent.n - 1)};
    if (!parent.rough_v.empty())
        out.rough = gather(parent.rough_v.data(), parent.rough_c.data(), parent_id, child_half, parent.n - 1);
    return out;
}

namespace {

// Greatest range within one triangle, of heights with fractions.
std::int64_t triangle_range(const std::int64_t* row, int cells) {
    std::int64_t range = 0;
    const auto widen = [&range](std::int64_t x, std::int64_t y, std::int64_t z) {
        range = std::max(range, std::max({x, y, z}) - std::min({x, y, z}));
    };
    for (int r = 0; r < cells; row += ++r) {
        // Corners of the cell whose vertices exist in this half: a triangle where c = r, by symmetry.
        const std::int64_t* const next = row + r + 1;
        for (int c = 0; c < r; ++c) {
            const bool main = main_diagonal(r, c);
            widen(row[c], next[c], main ? next[c + 1] : row[c + 1]);
            widen(main ? row[c] : next[c], next[c + 1], row[c + 1]);
        }
        widen(row[r], next[r], next[r + 1]);
    }
    return range;
}

}  // namespace

HalfRange half_range(const HalfHeights& heights, int cells, double quantum) {
    if (heights.fine.empty()) {
        const WholeRange r = whole_range(heights.whole, cells);
        return {r.least * quantum, r.greatest * quantum, r.in_triangle * quantum};
    }
    const double metres = quantum * kHeightFraction;
    const auto [least, greatest] = std::minmax_element(heights.fine.begin(), heights.fine.end());
    return {static_cast<double>(*least) * metres, static_cast<double>(*greatest) * metres,
            static_cast<double>(triangle_range(heights.fine.data(), cells)) * metres};
}

}  // namespace carat
