// A logical device with one queue. Work is ordered by one timeline semaphore: submit() returns the value that
// it reaches.
#pragma once

#include <cstdint>
#include <string>

#include "check.hpp"
#include "instance.hpp"

namespace carat::vk {

class Device {
  public:
    // `wish`: part of a name, or an index; empty: the best kind. Throws Error(usage) for a wish that nothing
    // fulfils and Error(unsupported) when no device has what we need.
    Device(const Instance& instance, const std::string& wish);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    VkDevice get() const { return device_; }
    VkPhysicalDevice physical() const { return physical_; }
    const VkPhysicalDeviceProperties& properties() const { return properties_; }
    std::string name() const { return properties_.deviceName; }
    std::uint64_t max_allocation() const { return max_allocation_; }
    // Whether fragment shaders may ask for the number of their triangle.
    bool has_primitive_numbers() const { return primitive_numbers_; }
    bool has_timestamps() const { return timestamp_bits_ > 0; }
    std::uint64_t timestamp_mask() const;

    VkCommandBuffer new_commands() const;
    void free_commands(VkCommandBuffer commands) const;
    // Starts a command buffer that will be submitted once.
    void begin(VkCommandBuffer commands) const;
    // Ends and submits; the timeline reaches the returned value when the work is done.
    std::uint64_t submit(VkCommandBuffer commands);
    void wait(std::uint64_t value) const;
    // True once the work of that value is done; never waits.
    bool done(std::uint64_t value) const;
    void wait_idle() const;

  private:
    void choose(const Instance& instance, const std::string& wish);
    void create();

    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties_{};
    std::uint64_t max_allocation_ = 0;
    std::uint32_t family_ = 0, timestamp_bits_ = 0;
    bool primitive_numbers_ = false;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    CommandPool pool_;
    Semaphore timeline_;
    std::uint64_t submitted_ = 0;
};

// Everything written before is visible to everything after.
void full_barrier(VkCommandBuffer commands);
// Everything written before is visible to the host once the work is done.
void host_barrier(VkCommandBuffer commands);

}  // namespace carat::vk
