// The codec's inner loops over whole matrices, vectorised with Highway: the best target of the processor is
// chosen at run time. Integer arithmetic modulo 2^32 only, so that every target gives the same bits as the
// plain loops in the tests.
#pragma once

#include <cstdint>
#include <vector>

#include "carat/codec/coding.hpp"

namespace carat {

// Vertex activities in rows of m + 2, one repeated at either end; weighted rows from one above to one below.
struct ActivityScratch {
    std::vector<std::uint32_t> vertices, rows;
};

// Scale of contexts for a quantiser step: activities are shifted right by `shift`, so that the step's own
// value fits 12 bits. No sum of cell_activity then exceeds 2^30.
struct ActivityScale {
    explicit ActivityScale(std::int32_t radius);
    int shift = 0;
    std::uint32_t step = 1;  // (2 radius + 1) >> shift, 1 to 4095
};

// How rough a matrix is around a cell, as contexts see it: in a window, best on terrain that is smooth, or at
// the cell's corners alone, best where it has edges.
enum class Activity : std::uint8_t { window = 0, corners = 1 };

namespace kernel {

// carat::predict_centres.
void predict(const std::int32_t* in, int m, Order order, std::int32_t* out);

// out[cell], (m-1) x (m-1): how rough the m x m matrix is around each cell. With D = |second difference along
// i| + |along j| of a vertex, each shifted and at most 2^23: D weighted 1 2 2 1 x 1 2 2 1 over the 4 x 4
// vertices around the cell, plus 8 |twist of the cell|, plus 24 steps; or 5 times D of its corners plus 7
// times the sum of |4 corner - sum of corners|, plus 24 steps. docs/format.md, "Contexts".
void cell_activity(const std::int32_t* in, int m, const ActivityScale& scale, Activity kind,
                   ActivityScratch& scratch, std::uint32_t* out);

// out[k] = base + clamp(floor((8 log2 u + bias) / 2), 0, 63) of u = activity[k] + weight * neighbours[k]
// (neighbours null: none), the logarithm piecewise linear: 8 floor(log2 u) + the three bits below the
// highest. u from 16 to 2^31 - 1.
void contexts(const std::uint32_t* activity, const std::uint8_t* neighbours, std::uint32_t weight,
              std::size_t count, int bias, std::uint8_t base, std::uint8_t* out);

// value[k] = prediction[k] + index[k] * step mod 2^32; the three arrays lie apart.
void reconstruct(const std::int32_t* prediction, const std::int32_t* index, std::size_t count,
                 std::int32_t step, std::int32_t* value);

// index[k] = nearest multiple of step = 2 radius + 1 to target[k] - prediction[k] (mod 2^32, signed):
// carat::quantize. Returns whether any is not zero.
bool quantize(const std::int32_t* target, const std::int32_t* prediction, std::size_t count,
              std::int32_t radius, std::int32_t* index);

}  // namespace kernel
}  // namespace carat
