// Prediction of cell centres from the vertices around them: Neville lifting (Kovacevic and Sweldens 2000).
#pragma once

#include <cstdint>

#include "carat/codec/coding.hpp"

namespace carat {

// out[(i, j)], an (m-1) x (m-1) matrix, predicts the centre of cell (i, j) of the m x m matrix `in`; m >= 4.
//
//   order 2    the mean of the 4 nearest, everywhere
//   order 4    interior cells   (10 * the 4 nearest - the 8 next) / 32
//              border cells     the 4 + 4 samples of the two rows along the border, (-1 9 9 -1)/32 each
//              corner cells     the mean of the 4 nearest
//   order 6    two cells from the border on   (174 * the 4 nearest - 27 * the 8 next + 2 * the 4 diagonal
//              + 3 * the 8 beyond) / 512; else as order 4
//
// All sums are exact and divided with rounding half up: floor((sum + d/2) / d). The result of hostile inputs
// may leave int32 and is reduced modulo 2^32. Vectorised; the same bits on every processor.
void predict_centres(const std::int32_t* in, int m, Order order, std::int32_t* out);
// The same, plainly, in int64: the reference of the tests.
void predict_centres_plain(const std::int32_t* in, int m, Order order, std::int32_t* out);

}  // namespace carat
