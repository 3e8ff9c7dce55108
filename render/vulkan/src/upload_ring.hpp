// Staging: bytes are gathered in segments of a ring of host memory and copied to device buffers segment by
// segment. A segment is written again only when the device has passed its value of the timeline.
#pragma once

#include <array>

#include "memory.hpp"

namespace carat::vk {

class UploadRing {
  public:
    UploadRing(Device& device, std::size_t bytes);

    // Schedules a copy; the bytes are taken at once. Any size: long copies are split over segments.
    void copy(VkBuffer target, std::size_t offset, const void* bytes, std::size_t size);
    // Submits what is gathered. Work submitted later sees it, if it begins with full_barrier().
    void flush();
    // Milliseconds spent so far waiting for the device to pass a segment: 0 while the ring is large enough.
    double stalled_ms() const { return stalled_ms_; }

  private:
    static constexpr std::size_t kSegments = 4;
    struct Segment {
        VkCommandBuffer commands = VK_NULL_HANDLE;
        std::uint64_t busy_until = 0;
    };
    struct Copy {
        VkBuffer target;
        VkBufferCopy region;
    };

    Device& device_;
    std::size_t segment_bytes_;
    Buffer staging_;
    std::array<Segment, kSegments> segments_{};
    std::size_t current_ = 0, used_ = 0;
    std::vector<Copy> copies_;
    double stalled_ms_ = 0;

    void wait_for_segment();
};

}  // namespace carat::vk
