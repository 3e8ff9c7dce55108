#include "gpu_timer.hpp"

#include <array>

namespace carat::vk {

GpuTimer::GpuTimer(const Device& device) : device_(device) {
    if (!device.has_timestamps()) return;
    const VkQueryPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                     .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                     .queryCount = 2};
    VkQueryPool pool = VK_NULL_HANDLE;
    check(vkCreateQueryPool(device.get(), &info, nullptr, &pool), "creating time stamps");
    queries_ = {device.get(), pool};
}

void GpuTimer::start(VkCommandBuffer commands) const {
    if (!queries_) return;
    vkCmdResetQueryPool(commands, queries_.get(), 0, 2);
    vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_.get(), 0);
}

void GpuTimer::stop(VkCommandBuffer commands) const {
    if (queries_) vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_.get(), 1);
}

double GpuTimer::milliseconds() const {
    if (!queries_) return 0;
    std::array<std::uint64_t, 2> stamps{};
    check(vkGetQueryPoolResults(device_.get(), queries_.get(), 0, 2, sizeof(stamps), stamps.data(),
                                sizeof(stamps[0]), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
          "reading time stamps");
    const std::uint64_t ticks = (stamps[1] - stamps[0]) & device_.timestamp_mask();
    return static_cast<double>(ticks) * device_.properties().limits.timestampPeriod * 1e-6;
}

}  // namespace carat::vk
