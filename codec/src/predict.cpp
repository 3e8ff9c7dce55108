#include "carat/codec/predict.hpp"

#include <cassert>

#include "kernels.hpp"

namespace carat {
namespace {

// Sum of samples at (rows, columns) from cell (i, j)'s low corner, all 8 or 4 that symmetry makes of (a, b):
// offsets in half cells from the centre, a and b odd.
std::int64_t ring(const std::int32_t* in, int m, int i, int j, int a, int b) {
    const auto at = [&](int x, int y) {
        return std::int64_t{in[static_cast<std::ptrdiff_t>(i + (x + 1) / 2) * m + j + (y + 1) / 2]};
    };
    std::int64_t sum = at(a, b) + at(a, -b) + at(-a, b) + at(-a, -b);
    if (a != b) sum += at(b, a) + at(b, -a) + at(-b, a) + at(-b, -a);
    return sum;
}

// One-sided rule: samples at a[k], a[k + step] ... along the border in two rows.
std::int64_t one_sided(const std::int32_t* a, const std::int32_t* b, int step) {
    const std::int64_t inner = std::int64_t{a[0]} + a[step] + b[0] + b[step];
    const std::int64_t outer = std::int64_t{a[-step]} + a[2 * step] + b[-step] + b[2 * step];
    return (9 * inner - outer + 16) >> 5;
}

std::int64_t predict_cell(const std::int32_t* in, int m, int i, int j, Order order) {
    const int last = m - 2;
    const auto fits = [&](int margin) {
        return i >= margin && i <= last - margin && j >= margin && j <= last - margin;
    };
    const auto near = [&] { return ring(in, m, i, j, 1, 1); };
    if (order == Order::six && fits(2))
        return (174 * near() - 27 * ring(in, m, i, j, 3, 1) + 2 * ring(in, m, i, j, 3, 3) +
                3 * ring(in, m, i, j, 5, 1) + 256) >>
               9;
    if (order != Order::two && fits(1)) return (10 * near() - ring(in, m, i, j, 3, 1) + 16) >> 5;
    const std::int32_t* at = in + static_cast<std::ptrdiff_t>(i) * m + j;
    const bool inner_row = i > 0 && i<last, inner_column = j> 0 && j < last;
    if (order != Order::two && inner_column) return one_sided(at, at + m, 1);
    if (order != Order::two && inner_row) return one_sided(at, at + 1, m);
    return (near() + 2) >> 2;
}

}  // namespace

void predict_centres(const std::int32_t* in, int m, Order order, std::int32_t* out) {
    assert(m >= 4);
    kernel::predict(in, m, order, out);
}

void predict_centres_plain(const std::int32_t* in, int m, Order order, std::int32_t* out) {
    assert(m >= 4);
    for (int i = 0; i < m - 1; ++i)
        for (int j = 0; j < m - 1; ++j)
            *out++ = static_cast<std::int32_t>(static_cast<std::uint32_t>(predict_cell(in, m, i, j, order)));
}

}  // namespace carat
