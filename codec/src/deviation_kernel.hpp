// The inner loop of max_deviation: a fine half against the coarse surface above it, vectorised.
#pragma once

#include <cstdint>

namespace carat::kernel {

// Where vertex (i, j) of the fine half lies in the coarse matrix: (x0 + i xi + j xj, y0 + i yi + j yj) / 8.
struct FinePlacement {
    int x0 = 0, xi = 0, xj = 0, y0 = 0, yi = 0, yj = 0;
};

// 8 times the greatest |coarse - fine| over the half `side` of the fine matrix; both n x n. All values that
// carry weight spread over at most 2^25: then no sum exceeds 32 bits.
std::int32_t max_deviation(const std::int32_t* coarse, const std::int32_t* fine, const FinePlacement& place,
                           int side, int n);

}  // namespace carat::kernel
