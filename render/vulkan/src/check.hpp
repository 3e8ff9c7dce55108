// Vulkan results to typed errors, and move-only owners of Vulkan objects.
#pragma once

#include <vulkan/vulkan.h>

#include <string>
#include <utility>
#include <vector>

#include "carat/globe/error.hpp"

namespace carat::vk {

const char* result_name(VkResult result);

// Throws Error(limit) when memory is out and Error(io) otherwise; `what` is what was being done.
void check(VkResult result, const std::string& what);

// An object of a device, destroyed with its owner. Empty by default.
template <class Handle, auto Destroy>
class Owned {
  public:
    Owned() = default;
    Owned(VkDevice device, Handle handle) : device_(device), handle_(handle) {}
    Owned(Owned&& other) noexcept
        : device_(other.device_), handle_(std::exchange(other.handle_, Handle{VK_NULL_HANDLE})) {}
    Owned& operator=(Owned&& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Owned() {
        if (handle_ != VK_NULL_HANDLE) Destroy(device_, handle_, nullptr);
    }
    Handle get() const { return handle_; }
    const Handle* address() const { return &handle_; }
    explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }

  private:
    VkDevice device_ = VK_NULL_HANDLE;
    Handle handle_ = VK_NULL_HANDLE;
};

using Memory = Owned<VkDeviceMemory, vkFreeMemory>;
using BufferHandle = Owned<VkBuffer, vkDestroyBuffer>;
using ImageHandle = Owned<VkImage, vkDestroyImage>;
using ImageView = Owned<VkImageView, vkDestroyImageView>;
using Sampler = Owned<VkSampler, vkDestroySampler>;
using ShaderModule = Owned<VkShaderModule, vkDestroyShaderModule>;
using Pipeline = Owned<VkPipeline, vkDestroyPipeline>;
using PipelineLayout = Owned<VkPipelineLayout, vkDestroyPipelineLayout>;
using PipelineCache = Owned<VkPipelineCache, vkDestroyPipelineCache>;
using SetLayout = Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>;
using DescriptorPool = Owned<VkDescriptorPool, vkDestroyDescriptorPool>;
using CommandPool = Owned<VkCommandPool, vkDestroyCommandPool>;
using Semaphore = Owned<VkSemaphore, vkDestroySemaphore>;
using QueryPool = Owned<VkQueryPool, vkDestroyQueryPool>;

// Vulkan's two-call lists.
template <class T, class Function, class... Args>
std::vector<T> enumerate(Function function, Args... args) {
    std::uint32_t count = 0;
    function(args..., &count, nullptr);
    std::vector<T> items(count);
    function(args..., &count, items.data());
    items.resize(count);
    return items;
}

}  // namespace carat::vk
