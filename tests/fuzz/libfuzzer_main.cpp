// One libFuzzer program a target: CARAT_FUZZ_TARGET names it.
#include <cstddef>
#include <cstdint>

#include "targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    carat::fuzz::CARAT_FUZZ_TARGET({reinterpret_cast<const std::byte*>(data), size});
    return 0;
}
