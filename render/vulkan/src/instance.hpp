// The Vulkan instance, with the validation layer's messages collected when asked for.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "check.hpp"

namespace carat::vk {

class Instance {
  public:
    // Throws Error(unsupported) without a Vulkan 1.3 loader, or without the layer when validation is asked
    // for.
    explicit Instance(bool validation);
    ~Instance();
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;

    VkInstance get() const { return instance_; }
    std::vector<VkPhysicalDevice> devices() const;
    // Warnings and errors of the layer so far. Thread-safe.
    std::vector<std::string> messages() const;

  private:
    struct Log {
        mutable std::mutex mutex;
        std::vector<std::string> messages;
    };
    static VKAPI_ATTR VkBool32 VKAPI_CALL listen(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                 VkDebugUtilsMessageTypeFlagsEXT,
                                                 const VkDebugUtilsMessengerCallbackDataEXT* data, void* log);

    std::unique_ptr<Log> log_ = std::make_unique<Log>();
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
};

}  // namespace carat::vk
