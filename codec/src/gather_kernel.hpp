// The inner loop of gather_half: half a child's vertices from the refined heights of its parent, vectorised.
#pragma once

#include <cstdint>

#include "carat/codec/heights.hpp"

namespace carat::kernel {

// out: n x n, of which `part` is written; v: n x n, c: (n-1) x (n-1) of the parent.
void gather_half(const std::int32_t* v, const std::int32_t* c, int n, const ChildMap& map, Triangle part,
                 std::int32_t* out);

}  // namespace carat::kernel
