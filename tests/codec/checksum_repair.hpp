// Makes the checksums of a damaged file right again, so that what lies behind them is tested: parts,
// directory blocks, directory, root values and header, as far as they lie inside the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace carat::test {

void repair_checksums(std::vector<std::byte>& file);

}  // namespace carat::test
