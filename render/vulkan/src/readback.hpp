// Images back to host memory, a band of rows at a time.
#pragma once

#include <functional>

#include "memory.hpp"

namespace carat::vk {

class Readback {
  public:
    explicit Readback(Device& device) : device_(device), commands_(device.new_commands()) {}

    // Calls `take(first_row, rows, pixels)` for bands from the top until the image is read. The image must be
    // in TRANSFER_SRC_OPTIMAL. Waits for the device.
    using Take = std::function<void(std::uint32_t first_row, std::uint32_t rows, const std::byte* pixels)>;
    void read(const Image& image, std::size_t pixel_bytes, const Take& take);

  private:
    Device& device_;
    VkCommandBuffer commands_;
    Buffer buffer_;
};

}  // namespace carat::vk
