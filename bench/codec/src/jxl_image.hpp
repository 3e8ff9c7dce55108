// JPEG XL of 8-bit RGB, one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace carat::bench {

// pixels: width * height * 3. distance 0: lossless. Effort 1 to 9.
std::vector<std::byte> jxl_encode_rgb(const std::vector<std::uint8_t>& pixels, int width, int height,
                                      float distance, int effort);
std::vector<std::uint8_t> jxl_decode_rgb(const std::vector<std::byte>& bytes, std::size_t samples);

}  // namespace carat::bench
