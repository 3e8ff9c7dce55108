// Prediction of cell centres from the vertices around them: Neville lifting (Kovacevic and Sweldens 2000).
#pragma once

#include <cstdint>

namespace carat {

// out[(i, j)], an (m-1) x (m-1) matrix, predicts the centre of cell (i, j) of the m x m matrix `in`; m >= 4.
//
//   interior cells   (10 * the 4 nearest - the 8 next) / 32             order 4
//   border cells     the 4 + 4 samples of the two rows along the border, (-1 9 9 -1)/32 each   one-sided
//   corner cells     the mean of the 4 nearest                                                  order 2
//
// All sums are exact in int64 and divided with rounding half up: floor((sum + d/2) / d). The result of
// hostile inputs may leave int32 and is reduced modulo 2^32.
void predict_centres(const std::int32_t* in, int m, std::int32_t* out);

}  // namespace carat
