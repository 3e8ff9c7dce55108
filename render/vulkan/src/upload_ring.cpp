#include "upload_ring.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>

namespace carat::vk {

UploadRing::UploadRing(Device& device, std::size_t bytes)
    : device_(device),
      segment_bytes_(std::max<std::size_t>(bytes / kSegments, 4096) & ~std::size_t{15}),
      staging_(make_buffer(device, segment_bytes_ * kSegments, VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                           Where::upload, "staging")) {
    for (auto& segment : segments_) segment.commands = device.new_commands();
}

void UploadRing::copy(VkBuffer target, std::size_t offset, const void* bytes, std::size_t size) {
    const auto* from = static_cast<const std::byte*>(bytes);
    while (size > 0) {
        if (used_ == segment_bytes_) flush();
        if (used_ == 0) wait_for_segment();
        const std::size_t part = std::min(size, segment_bytes_ - used_);
        const std::size_t place = current_ * segment_bytes_ + used_;
        std::memcpy(staging_.mapped + place, from, part);
        copies_.push_back({target, {place, offset, part}});
        used_ = std::min((used_ + part + 15) & ~std::size_t{15}, segment_bytes_);
        from += part;
        offset += part;
        size -= part;
    }
}

void UploadRing::wait_for_segment() {
    const std::uint64_t value = segments_[current_].busy_until;
    if (device_.done(value)) return;
    const auto start = std::chrono::steady_clock::now();
    device_.wait(value);
    stalled_ms_ +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

void UploadRing::flush() {
    if (used_ == 0) return;
    Segment& segment = segments_[current_];
    device_.begin(segment.commands);
    full_barrier(segment.commands);  // earlier work may still read what is overwritten
    for (const Copy& copy : copies_) {
        vkCmdCopyBuffer(segment.commands, staging_.handle.get(), copy.target, 1, &copy.region);
    }
    segment.busy_until = device_.submit(segment.commands);
    copies_.clear();
    used_ = 0;
    current_ = (current_ + 1) % kSegments;
}

}  // namespace carat::vk
