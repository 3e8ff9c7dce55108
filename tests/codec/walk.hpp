// Reads a repository as its users do, coarse to fine from the six faces, and reduces all it says to one
// number.
#pragma once

#include <cstdint>
#include <memory>

#include "carat/codec/repository.hpp"

namespace carat::test {

// Hash of the header, the heights and the summaries of at most `diamonds` diamonds. Throws what the
// repository throws.
std::uint64_t walk(const std::shared_ptr<const Repository>& repository, int diamonds = 100000);

// Hash of the heights alone.
std::uint64_t hash_heights(const std::shared_ptr<const Repository>& repository);

}  // namespace carat::test
