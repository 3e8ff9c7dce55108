// Command buffers that are used once and taken again when the device has passed them.
#pragma once

#include <deque>

#include "device.hpp"

namespace carat::vk {

class CommandBuffers {
  public:
    explicit CommandBuffers(Device& device) : device_(device) {}

    // A begun command buffer. Never waits: makes another one while all are under way.
    VkCommandBuffer begin();
    // Ends and submits the buffer that begin() gave last; returns the value of the timeline that it reaches.
    std::uint64_t submit();

  private:
    struct Used {
        VkCommandBuffer commands;
        std::uint64_t busy_until;
    };
    Device& device_;
    VkCommandBuffer current_ = VK_NULL_HANDLE;
    std::deque<Used> used_;  // oldest first
};

}  // namespace carat::vk
