#include "gather_kernel.hpp"

#include <algorithm>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gather_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carat::kernel::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// begin + i * step.
struct Line {
    std::ptrdiff_t begin, step;
    HWY_INLINE std::ptrdiff_t at(std::ptrdiff_t i) const { return begin + i * step; }
};

// What is taken from a parent, and into where.
struct Task {
    const std::int32_t* v;  // n x n
    const std::int32_t* c;  // (n - 1) x (n - 1)
    std::ptrdiff_t n;
    ChildMap m;
    Line begin, end;  // columns of row i
    std::int32_t* out;
};

HWY_INLINE Task task(const std::int32_t* v, const std::int32_t* c, std::ptrdiff_t n, const ChildMap& m,
                     Triangle part, std::int32_t* out) {
    switch (part) {
        case Triangle::left_lower:
            return {v, c, n, m, {0, 0}, {1, 1}, out};
        case Triangle::right_upper:
            return {v, c, n, m, {0, 1}, {n, 0}, out};
        case Triangle::left_upper:
            return {v, c, n, m, {0, 0}, {n, -1}, out};
        case Triangle::right_lower:
            break;
    }
    return {v, c, n, m, {n - 1, -1}, {n, 0}, out};
}

// Where (i, j) lies in its matrix; `of_v`: the vertices, else the cells. Outside the half it may lie
// anywhere.
struct Place {
    bool of_v;
    std::ptrdiff_t offset;
};
HWY_INLINE Place place(const Task& t, std::ptrdiff_t i, std::ptrdiff_t j) {
    const std::ptrdiff_t p = t.m.p0 + i * t.m.pi + j * t.m.pj, q = t.m.q0 + i * t.m.qi + j * t.m.qj;
    const bool vertex = (p & 1) == 0;
    return {vertex, (p >> 1) * (vertex ? t.n : t.n - 1) + (q >> 1)};
}

// V and C take turns along a row, each along a diagonal of its matrix.
HWY_INLINE void gather_row_plainly(const Task& t, std::ptrdiff_t i) {
    const std::ptrdiff_t begin = t.begin.at(i), end = t.end.at(i);
    for (std::ptrdiff_t first = begin; first < std::min(begin + 2, end); ++first) {
        const Place at = place(t, i, first);
        const std::int32_t* matrix = at.of_v ? t.v : t.c;
        const std::ptrdiff_t step = t.m.pj * (at.of_v ? t.n : t.n - 1) + t.m.qj;
        std::ptrdiff_t from = at.offset;
        for (std::ptrdiff_t j = first; j < end; j += 2, from += step) t.out[i * t.n + j] = matrix[from];
    }
}

#if HWY_TARGET == HWY_SCALAR || HWY_MAX_BYTES < 32
void GatherHalf(const std::int32_t* v, const std::int32_t* c, int size, const ChildMap& m, Triangle part,
                std::int32_t* out) {
    const Task t = task(v, c, size, m, part, out);
    for (std::ptrdiff_t i = 0; i < t.n; ++i) gather_row_plainly(t, i);
}
#else
constexpr std::ptrdiff_t kTile = 8;
using Row = hn::FixedTag<std::int32_t, kTile>;
using Four = hn::FixedTag<std::int32_t, kTile / 2>;
using RowV = hn::Vec<Row>;

// Lanes from .. from + 3 of two rows, beside each other.
HWY_INLINE RowV beside(const std::int32_t* low, const std::int32_t* high) {
    const Four four;
    return hn::Combine(Row(), hn::LoadU(four, high), hn::LoadU(four, low));
}

// Four rows of two 4 x 4 matrices side by side, each transposed: to[r] is what was column r.
HWY_INLINE void transpose_fours(RowV a, RowV b, RowV c, RowV d, RowV* to) {
    const Row row;
    const hn::Repartition<std::int64_t, Row> wide;
    const auto ab_low = hn::BitCast(wide, hn::InterleaveLower(row, a, b)),
               ab_high = hn::BitCast(wide, hn::InterleaveUpper(row, a, b)),
               cd_low = hn::BitCast(wide, hn::InterleaveLower(row, c, d)),
               cd_high = hn::BitCast(wide, hn::InterleaveUpper(row, c, d));
    to[0] = hn::BitCast(row, hn::InterleaveLower(wide, ab_low, cd_low));
    to[1] = hn::BitCast(row, hn::InterleaveUpper(wide, ab_low, cd_low));
    to[2] = hn::BitCast(row, hn::InterleaveLower(wide, ab_high, cd_high));
    to[3] = hn::BitCast(row, hn::InterleaveUpper(wide, ab_high, cd_high));
}

// Where the first of a parallelogram's even or odd columns begins, and how far apart they are.
struct Columns {
    const std::int32_t* matrix;
    std::ptrdiff_t size, offset, step;

    HWY_INLINE const std::int32_t* begin() const { return matrix + offset; }
    HWY_INLINE bool inside() const {
        const std::ptrdiff_t last = offset + 3 * step;
        return std::min(offset, last) >= 0 && std::max(offset, last) + kTile <= size;
    }
    // Four columns; those values outside the matrix, which nobody asks for, as 0.
    void copy(std::int32_t* to) const {
        for (std::ptrdiff_t k = 0; k < kTile / 2; ++k, to += kTile)
            for (std::ptrdiff_t r = 0, from = offset + k * step; r < kTile; ++r, ++from)
                to[r] = from >= 0 && from < size ? matrix[from] : 0;
    }
};

// Rows of a parallelogram out of its columns.
HWY_INLINE void turn(const std::int32_t* even, std::ptrdiff_t even_step, const std::int32_t* odd,
                     std::ptrdiff_t odd_step, RowV* rows) {
    for (std::ptrdiff_t half = 0; half < kTile; half += kTile / 2, even += kTile / 2, odd += kTile / 2)
        transpose_fours(beside(even, even + 2 * even_step), beside(odd, odd + 2 * odd_step),
                        beside(even + even_step, even + 3 * even_step),
                        beside(odd + odd_step, odd + 3 * odd_step), rows + half);
}

// Parallelograms beside each other, of which every value is asked for.
HWY_NOINLINE void whole_tiles(const std::int32_t* even, std::ptrdiff_t even_step, const std::int32_t* odd,
                              std::ptrdiff_t odd_step, std::ptrdiff_t count, std::int32_t* out,
                              std::ptrdiff_t out_step) {
    const Row d;
    for (; count > 0; --count) {
        RowV rows[kTile];
        turn(even, even_step, odd, odd_step, rows);
        std::int32_t* to = out;
        for (const RowV& row : rows) {
            hn::StoreU(row, d, to);
            to += out_step;
        }
        even += kTile / 2 * even_step;
        odd += kTile / 2 * odd_step;
        out += kTile;
    }
}

// Of a parallelogram's row r the lanes begin.at(r) to end.at(r) - 1.
HWY_NOINLINE void part_of_tile(const Columns& even, const Columns& odd, Line begin, Line end,
                               std::int32_t* out, std::ptrdiff_t out_step) {
    RowV rows[kTile];
    if (even.inside() && odd.inside()) {
        turn(even.begin(), even.step, odd.begin(), odd.step, rows);
    } else {
        alignas(32) std::int32_t e[kTile / 2 * kTile], o[kTile / 2 * kTile];
        even.copy(e);
        odd.copy(o);
        turn(e, kTile, o, kTile, rows);
    }
    const Row d;
    const hn::RebindToUnsigned<Row> du;
    const auto set = [d](std::ptrdiff_t x) { return hn::Set(d, static_cast<std::int32_t>(x)); };
    const auto begin_step = set(begin.step), count_step = set(end.step - begin.step);
    auto lane = hn::Sub(hn::Iota(d, 0), set(begin.begin)), count = set(end.begin - begin.begin);
    for (const RowV& row : rows) {  // no count is below 0
        hn::BlendedStore(row, hn::RebindMask(d, hn::Lt(hn::BitCast(du, lane), hn::BitCast(du, count))), d,
                         out);
        lane = hn::Sub(lane, begin_step);
        count = hn::Add(count, count_step);
        out += out_step;
    }
}

// Eight rows of a half, from `i` on, in parallelograms: row i + r of one holds the columns j + r slant .. j +
// r slant + 7. Along a row of a parent's matrix i and j change by one with each value, so that rows of the
// parent, of V and of C in turn, are a parallelogram's columns.
void gather_band(const Task& t, std::ptrdiff_t i) {
    const std::ptrdiff_t down = t.m.qi, slant = -t.m.pi * t.m.pj;  // with each value of a parent's row
    const std::ptrdiff_t first = down > 0 ? i : i + kTile - 1, last = down > 0 ? i + kTile - 1 : i;
    // Columns of the first row, of the last as the slant takes them there.
    const Line begin{t.begin.at(first), t.begin.step * down - down * slant},
        end{t.end.at(first), t.end.step * down - down * slant};
    const std::ptrdiff_t rows = (last - first) * down, last_begin = begin.at(rows), last_end = end.at(rows);
    const std::ptrdiff_t from = std::min(begin.begin, last_begin), to = std::max(end.begin, last_end),
                         whole_from = std::max(begin.begin, last_begin),
                         whole_to = std::min(end.begin, last_end);
    const auto columns = [&](std::ptrdiff_t j) {
        const Place at = place(t, first, j);
        const std::ptrdiff_t width = at.of_v ? t.n : t.n - 1;
        return Columns{at.of_v ? t.v : t.c, width * width, at.offset, t.m.pj * width + t.m.qj};
    };
    Columns even = columns(from), odd = columns(from + 1);
    const std::ptrdiff_t out_step = down * (t.n + slant);
    std::int32_t* out = t.out + first * t.n;
    for (std::ptrdiff_t j = from; j < to;) {
        std::ptrdiff_t count = 1;
        if (j >= whole_from && j + kTile <= whole_to) {
            count = (whole_to - j) / kTile;
            whole_tiles(even.begin(), even.step, odd.begin(), odd.step, count, out + j, out_step);
        } else {
            part_of_tile(even, odd, {begin.begin - j, begin.step}, {end.begin - j, end.step}, out + j,
                         out_step);
        }
        j += count * kTile;
        even.offset += count * (kTile / 2) * even.step;
        odd.offset += count * (kTile / 2) * odd.step;
    }
}

void GatherHalf(const std::int32_t* v, const std::int32_t* c, int size, const ChildMap& m, Triangle part,
                std::int32_t* out) {
    const Task t = task(v, c, size, m, part, out);
    std::ptrdiff_t i = 0;
    for (; i + kTile <= t.n; i += kTile) gather_band(t, i);
    for (; i < t.n; ++i) gather_row_plainly(t, i);
}
#endif

}  // namespace carat::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat::kernel {

HWY_EXPORT(GatherHalf);

void gather_half(const std::int32_t* v, const std::int32_t* c, int n, const ChildMap& map, Triangle part,
                 std::int32_t* out) {
    HWY_DYNAMIC_DISPATCH(GatherHalf)(v, c, n, map, part, out);
}

}  // namespace carat::kernel
#endif  // HWY_ONCE
