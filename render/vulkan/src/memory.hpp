// Buffers and images, each with an allocation of its own: there are few, and they are large.
#pragma once

#include <cstddef>

#include "device.hpp"

namespace carat::vk {

enum class Where { device, upload, readback };  // device memory; host memory to write; host memory to read

struct Buffer {
    Memory memory;
    BufferHandle handle;
    std::size_t size = 0;
    std::byte* mapped = nullptr;  // upload and readback: coherent
};
// Throws Error(limit) naming `what` when there is not enough memory.
Buffer make_buffer(const Device& device, std::size_t size, VkBufferUsageFlags usage, Where where,
                   const char* what);

struct Image {
    Memory memory;
    ImageHandle handle;
    ImageView view;
    VkFormat format = VK_FORMAT_UNDEFINED;
    VkExtent2D extent{};
};
struct ImageWish {
    VkExtent2D extent{};
    VkFormat format = VK_FORMAT_UNDEFINED;
    VkImageUsageFlags usage = 0;
    VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
    std::uint32_t layers = 1;  // more than 1: viewed as an array
    const char* what = "";
};
Image make_image(const Device& device, const ImageWish& wish);

// Whole image, every layer, from one layout to another, after and before everything.
void change_layout(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to);

}  // namespace carat::vk
