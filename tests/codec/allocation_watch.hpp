// Allocations of the process: linked into tests that bound what damaged files may ask for, or what the hot
// path does.
#pragma once

#include <cstddef>

namespace carat::test {

// Since forget_allocations(), or the start: the largest single one, bytes, and how many.
std::size_t largest_allocation();
std::size_t allocations();
void forget_allocations();

}  // namespace carat::test
