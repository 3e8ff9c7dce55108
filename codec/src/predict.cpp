#include "carat/codec/predict.hpp"

#include <cassert>
#include <initializer_list>

namespace carat {
namespace {

std::int32_t low32(std::int64_t x) { return static_cast<std::int32_t>(static_cast<std::uint32_t>(x)); }

// (10 * nearest - next + 16) >> 5 for the interior of one row of cells; r0..r3 are the rows i-1..i+2.
void interior_row(const std::int32_t* r0, const std::int32_t* r1, const std::int32_t* r2,
                  const std::int32_t* r3, int m, std::int32_t* out) {
    for (int j = 1; j < m - 2; ++j) {
        const std::int64_t nearest = std::int64_t{r1[j]} + r1[j + 1] + r2[j] + r2[j + 1];
        const std::int64_t next = std::int64_t{r0[j]} + r0[j + 1] + r3[j] + r3[j + 1] + r1[j - 1] +
                                  r1[j + 2] + r2[j - 1] + r2[j + 2];
        out[j] = low32((10 * nearest - next + 16) >> 5);
    }
}

// One-sided rule: samples at a[k], a[k + step] ... along the border in two rows.
std::int32_t one_sided(const std::int32_t* a, const std::int32_t* b, int step) {
    const std::int64_t inner = std::int64_t{a[0]} + a[step] + b[0] + b[step];
    const std::int64_t outer = std::int64_t{a[-step]} + a[2 * step] + b[-step] + b[2 * step];
    return low32((9 * inner - outer + 16) >> 5);
}

std::int32_t corner(const std::int32_t* a, int m) {
    return low32((std::int64_t{a[0]} + a[1] + a[m] + a[m + 1] + 2) >> 2);
}

}  // namespace

void predict_centres(const std::int32_t* in, int m, std::int32_t* out) {
    assert(m >= 4);
    const int last = m - 2;  // last row and column of cells
    const auto row = [&](int i) { return in + static_cast<std::ptrdiff_t>(i) * m; };
    const auto out_row = [&](int i) { return out + static_cast<std::ptrdiff_t>(i) * (m - 1); };
    for (int i = 1; i < last; ++i) {
        interior_row(row(i - 1), row(i), row(i + 1), row(i + 2), m, out_row(i));
        out_row(i)[0] = one_sided(row(i), row(i) + 1, m);
        out_row(i)[last] = one_sided(row(i) + last, row(i) + last + 1, m);
    }
    for (const int i : {0, last}) {
        for (int j = 1; j < last; ++j) out_row(i)[j] = one_sided(row(i) + j, row(i + 1) + j, 1);
        out_row(i)[0] = corner(row(i), m);
        out_row(i)[last] = corner(row(i) + last, m);
    }
}

}  // namespace carat
