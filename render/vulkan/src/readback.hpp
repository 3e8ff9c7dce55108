// Images back to host memory: whole ones with the frame's own commands, or a band of rows at a time.
#pragma once

#include <functional>
#include <span>

#include "memory.hpp"

namespace carat::vk {

// Calls `take(first_row, rows, pixels)` for bands from the top until the image is read.
using TakeRows = std::function<void(std::uint32_t first_row, std::uint32_t rows, const std::byte* pixels)>;

struct ImageRead {
    const Image* image = nullptr;  // in TRANSFER_SRC_OPTIMAL when copied; not needed afterwards
    VkExtent2D extent{};
    std::size_t pixel_bytes = 0;
    TakeRows take;

    std::size_t bytes() const { return std::size_t{extent.width} * extent.height * pixel_bytes; }
};

// Whole images, copied by the device behind the drawing: no wait until they are taken.
class WholeReadback {
  public:
    // Records the copies; the images must stay until the commands have finished.
    void record(const Device& device, VkCommandBuffer commands, std::span<const ImageRead> reads);
    // After the commands have finished: hands every image to its `take`, in one band.
    void take(std::span<const ImageRead> reads) const;

  private:
    Buffer buffer_;
};

// Band by band, for pictures too large for a second copy in host memory. Waits for the device.
class BandedReadback {
  public:
    explicit BandedReadback(Device& device) : device_(device), commands_(device.new_commands()) {}
    void read(const ImageRead& read);

  private:
    Device& device_;
    VkCommandBuffer commands_;
    Buffer buffer_;
};

}  // namespace carat::vk
