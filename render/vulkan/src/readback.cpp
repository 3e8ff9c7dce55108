#include "readback.hpp"

#include <algorithm>

namespace carat::vk {

namespace {

constexpr std::size_t kBandBytes = std::size_t{64} << 20;

void record_copy(VkCommandBuffer commands, const Image& image, std::uint32_t row, std::uint32_t rows,
                 const Buffer& buffer, std::size_t offset) {
    const VkBufferImageCopy region{.bufferOffset = offset,
                                   .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                   .imageOffset = {0, static_cast<std::int32_t>(row), 0},
                                   .imageExtent = {image.extent.width, rows, 1}};
    vkCmdCopyImageToBuffer(commands, image.handle.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                           buffer.handle.get(), 1, &region);
}

Buffer host_buffer(const Device& device, std::size_t bytes) {
    return make_buffer(device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Where::readback, "reading back");
}

// Where the next image may begin: a multiple of every pixel size and of 4.
std::size_t aligned(std::size_t offset) { return (offset + 15) & ~std::size_t{15}; }

}  // namespace

void WholeReadback::record(const Device& device, VkCommandBuffer commands, std::span<const ImageRead> reads) {
    std::size_t bytes = 0;
    for (const ImageRead& read : reads) bytes = aligned(bytes) + read.bytes();
    if (buffer_.size < bytes) {
        buffer_ = {};
        buffer_ = host_buffer(device, bytes);
    }
    full_barrier(commands);
    std::size_t offset = 0;
    for (const ImageRead& read : reads) {
        offset = aligned(offset);
        record_copy(commands, *read.image, 0, read.extent.height, buffer_, offset);
        offset += read.bytes();
    }
    host_barrier(commands);
}

void WholeReadback::take(std::span<const ImageRead> reads) const {
    std::size_t offset = 0;
    for (const ImageRead& read : reads) {
        offset = aligned(offset);
        read.take(0, read.extent.height, buffer_.mapped + offset);
        offset += read.bytes();
    }
}

void BandedReadback::read(const ImageRead& read) {
    const std::size_t row_bytes = read.extent.width * read.pixel_bytes;
    const auto band =
        static_cast<std::uint32_t>(std::clamp<std::size_t>(kBandBytes / row_bytes, 1, read.extent.height));
    if (buffer_.size < band * row_bytes) {
        buffer_ = {};
        buffer_ = host_buffer(device_, band * row_bytes);
    }
    for (std::uint32_t row = 0; row < read.extent.height; row += band) {
        const std::uint32_t rows = std::min(band, read.extent.height - row);
        device_.begin(commands_);
        full_barrier(commands_);
        record_copy(commands_, *read.image, row, rows, buffer_, 0);
        host_barrier(commands_);
        device_.wait(device_.submit(commands_));
        read.take(row, rows, buffer_.mapped);
    }
}

}  // namespace carat::vk
