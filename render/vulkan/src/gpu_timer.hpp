// Time between two points of a command buffer, by the device's time stamps.
#pragma once

#include "device.hpp"

namespace carat::vk {

class GpuTimer {
  public:
    explicit GpuTimer(const Device& device);

    void start(VkCommandBuffer commands) const;
    void stop(VkCommandBuffer commands) const;
    // After the commands have finished; 0 where the device has no time stamps.
    double milliseconds() const;

  private:
    const Device& device_;
    QueryPool queries_;
};

}  // namespace carat::vk
