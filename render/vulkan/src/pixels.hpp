// Device pixels to pictures. Pixels are counted row-major; `first` is the first pixel of the band.
#pragma once

#include <cstddef>

#include "carat/vulkan/picture.hpp"

namespace carat {

Picture empty_picture(int width, int height, std::vector<std::string> channels);

// RGBA half to all four channels.
void take_half4(Picture& picture, std::size_t first, std::size_t count, const std::byte* pixels);
// Four floats a pixel: the picture's channels are taken from the `offset`-th on.
void take_float4(Picture& picture, std::size_t first, std::size_t count, const std::byte* pixels,
                 std::size_t offset);

}  // namespace carat
