// The update of modes 1 and 2: inner vertices of a diamond, vectorised with Highway like kernels.hpp.
// Matrices of vertices are n x n, n >= 5; those of inner vertices (n-2) x (n-2), element (i, j) for the
// vertex (i+1, j+1). Border vertices are neither read nor written. Integer arithmetic modulo 2^32.
#pragma once

#include <cstdint>

namespace carat::kernel {

// What predicts the inner vertices: p itself (mode 1, predicted null) or 2 p - predicted (mode 2), predicted
// of the inner vertices.
struct VertexBase {
    const std::int32_t* p;
    const std::int32_t* predicted;
};

// index = nearest multiple of 2 radius + 1 to v - base: carat::quantize.
void quantize_vertices(const std::int32_t* v, const VertexBase& base, int n, std::int32_t radius,
                       std::int32_t* index);

// v = base + index * step inside; v lies apart from p.
void update_vertices(const VertexBase& base, const std::int32_t* index, int n, std::int32_t step,
                     std::int32_t* v);

// p = (v + predicted) / 2 inside, rounded half up, held within +-kGreatestHeight. `predicted` may stand at
// the beginning of p.
void filter_vertices(const std::int32_t* v, const std::int32_t* predicted, int n, std::int32_t* p);

}  // namespace carat::kernel
