// The largest single allocation of the process so far: linked into tests that bound what damaged files may
// ask for.
#pragma once

#include <cstddef>

namespace carat::test {

std::size_t largest_allocation();
void forget_allocations();

}  // namespace carat::test
