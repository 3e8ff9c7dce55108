#include "readback.hpp"

#include <algorithm>

namespace carat::vk {

namespace {

constexpr std::size_t kBandBytes = std::size_t{64} << 20;

}  // namespace

void Readback::read(const Image& image, std::size_t pixel_bytes, const Take& take) {
    const std::size_t row_bytes = image.extent.width * pixel_bytes;
    const auto band =
        static_cast<std::uint32_t>(std::clamp<std::size_t>(kBandBytes / row_bytes, 1, image.extent.height));
    if (buffer_.size < band * row_bytes) {
        buffer_ = make_buffer(device_, band * row_bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Where::readback,
                              "reading back");
    }
    for (std::uint32_t row = 0; row < image.extent.height; row += band) {
        const std::uint32_t rows = std::min(band, image.extent.height - row);
        device_.begin(commands_);
        full_barrier(commands_);
        const VkBufferImageCopy region{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                       .imageOffset = {0, static_cast<std::int32_t>(row), 0},
                                       .imageExtent = {image.extent.width, rows, 1}};
        vkCmdCopyImageToBuffer(commands_, image.handle.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                               buffer_.handle.get(), 1, &region);
        host_barrier(commands_);
        device_.wait(device_.submit(commands_));
        take(row, rows, buffer_.mapped);
    }
}

}  // namespace carat::vk
