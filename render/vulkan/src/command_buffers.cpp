#include "command_buffers.hpp"

namespace carat::vk {

VkCommandBuffer CommandBuffers::begin() {
    if (!used_.empty() && device_.done(used_.front().busy_until)) {
        current_ = used_.front().commands;
        used_.pop_front();
    } else {
        current_ = device_.new_commands();
    }
    device_.begin(current_);
    return current_;
}

std::uint64_t CommandBuffers::submit() {
    const std::uint64_t value = device_.submit(current_);
    used_.push_back({current_, value});
    return value;
}

}  // namespace carat::vk
