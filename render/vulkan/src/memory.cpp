#include "memory.hpp"

namespace carat::vk {

namespace {

// The first memory type allowed by `bits` that has all of `wanted`, or -1.
int find_type(const VkPhysicalDeviceMemoryProperties& memory, std::uint32_t bits,
              VkMemoryPropertyFlags wanted) {
    for (std::uint32_t t = 0; t < memory.memoryTypeCount; ++t) {
        if ((bits >> t & 1u) != 0 && (memory.memoryTypes[t].propertyFlags & wanted) == wanted)
            return static_cast<int>(t);
    }
    return -1;
}

std::uint32_t memory_type(const Device& device, std::uint32_t bits, Where where) {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(device.physical(), &memory);
    const VkMemoryPropertyFlags host =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkMemoryPropertyFlags first = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, second = 0;
    if (where == Where::upload) first = second = host;
    if (where == Where::readback) first = host | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, second = host;
    int type = find_type(memory, bits, first);
    if (type < 0) type = find_type(memory, bits, second);
    if (type < 0) throw Error(ErrorCode::unsupported, "Vulkan: " + device.name() + " has no suitable memory");
    return static_cast<std::uint32_t>(type);
}

Memory allocate(const Device& device, const VkMemoryRequirements& needs, Where where, const char* what) {
    const auto mebibytes = std::to_string(needs.size >> 20) + " MiB for " + what + " on " + device.name();
    if (needs.size > device.max_allocation()) {
        throw Error(ErrorCode::limit, "Vulkan: " + mebibytes + ": more than the device gives at once");
    }
    const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                    .allocationSize = needs.size,
                                    .memoryTypeIndex = memory_type(device, needs.memoryTypeBits, where)};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    check(vkAllocateMemory(device.get(), &info, nullptr, &memory), mebibytes);
    return {device.get(), memory};
}

}  // namespace

Buffer make_buffer(const Device& device, std::size_t size, VkBufferUsageFlags usage, Where where,
                   const char* what) {
    const VkBufferCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    VkBuffer handle = VK_NULL_HANDLE;
    check(vkCreateBuffer(device.get(), &info, nullptr, &handle),
          std::string("creating a buffer for ") + what);
    Buffer buffer{.memory = {}, .handle = {device.get(), handle}, .size = size};
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device.get(), handle, &needs);
    buffer.memory = allocate(device, needs, where, what);
    check(vkBindBufferMemory(device.get(), handle, buffer.memory.get(), 0), "binding a buffer");
    if (where != Where::device) {
        void* address = nullptr;
        check(vkMapMemory(device.get(), buffer.memory.get(), 0, VK_WHOLE_SIZE, 0, &address),
              "mapping memory");
        buffer.mapped = static_cast<std::byte*>(address);
    }
    return buffer;
}

Image make_image(const Device& device, const ImageWish& wish) {
    const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                 .imageType = VK_IMAGE_TYPE_2D,
                                 .format = wish.format,
                                 .extent = {wish.extent.width, wish.extent.height, 1},
                                 .mipLevels = 1,
                                 .arrayLayers = wish.layers,
                                 .samples = wish.samples,
                                 .tiling = VK_IMAGE_TILING_OPTIMAL,
                                 .usage = wish.usage};
    VkImage handle = VK_NULL_HANDLE;
    check(vkCreateImage(device.get(), &info, nullptr, &handle),
          std::string("creating an image for ") + wish.what);
    Image image;
    image.handle = {device.get(), handle};
    image.format = wish.format;
    image.extent = wish.extent;
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(device.get(), handle, &needs);
    image.memory = allocate(device, needs, Where::device, wish.what);
    check(vkBindImageMemory(device.get(), handle, image.memory.get(), 0), "binding an image");

    const bool depth = wish.format == VK_FORMAT_D32_SFLOAT;
    const VkImageViewCreateInfo view{
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = handle,
        .viewType = wish.layers > 1 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D,
        .format = wish.format,
        .subresourceRange = {
            static_cast<VkImageAspectFlags>(depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT), 0,
            1, 0, wish.layers}};
    VkImageView view_handle = VK_NULL_HANDLE;
    check(vkCreateImageView(device.get(), &view, nullptr, &view_handle), "viewing an image");
    image.view = {device.get(), view_handle};
    return image;
}

void change_layout(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to) {
    const bool depth = image.format == VK_FORMAT_D32_SFLOAT;
    const VkAccessFlags2 all = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    const VkImageMemoryBarrier2 barrier{
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .srcAccessMask = all,
        .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        .dstAccessMask = all,
        .oldLayout = from,
        .newLayout = to,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image.handle.get(),
        .subresourceRange = {
            static_cast<VkImageAspectFlags>(depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT), 0,
            1, 0, VK_REMAINING_ARRAY_LAYERS}};
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                .imageMemoryBarrierCount = 1,
                                .pImageMemoryBarriers = &barrier};
    vkCmdPipelineBarrier2(commands, &info);
}

}  // namespace carat::vk
