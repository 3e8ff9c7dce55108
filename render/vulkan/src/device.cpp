#include "device.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

namespace carat::vk {

namespace {

struct Features {
    VkPhysicalDeviceVulkan13Features v13{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceVulkan12Features v12{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                         .pNext = &v13};
    VkPhysicalDeviceFeatures2 base{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &v12};
};

std::optional<std::uint32_t> graphics_family(VkPhysicalDevice device) {
    const auto families =
        enumerate<VkQueueFamilyProperties>(vkGetPhysicalDeviceQueueFamilyProperties, device);
    for (std::uint32_t f = 0; f < families.size(); ++f) {
        const VkQueueFlags needed = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
        if ((families[f].queueFlags & needed) == needed) return f;
    }
    return std::nullopt;
}

VkPhysicalDeviceProperties properties_of(VkPhysicalDevice device) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(device, &properties);
    return properties;
}

// What the device lacks; empty if it will do.
std::string shortcoming(VkPhysicalDevice device) {
    if (properties_of(device).apiVersion < VK_API_VERSION_1_3) return "Vulkan 1.3";
    Features f;
    vkGetPhysicalDeviceFeatures2(device, &f.base);
    if (!f.base.features.shaderInt64) return "shaderInt64";
    if (!f.base.features.multiDrawIndirect) return "multiDrawIndirect";
    if (!f.base.features.drawIndirectFirstInstance) return "drawIndirectFirstInstance";
    if (!f.v12.timelineSemaphore) return "timelineSemaphore";
    if (!f.v13.dynamicRendering) return "dynamicRendering";
    if (!f.v13.synchronization2) return "synchronization2";
    if (!graphics_family(device)) return "a queue for graphics and compute";
    return "";
}

int rank(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            return 0;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            return 1;
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
            return 2;
        default:
            return 3;
    }
}

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

bool fulfils(const std::string& wish, std::size_t index, const std::string& name) {
    std::size_t number = 0;
    const char* end = wish.data() + wish.size();
    const auto [rest, error] = std::from_chars(wish.data(), end, number);
    if (error == std::errc() && rest == end) return number == index;
    return lower(name).find(lower(wish)) != std::string::npos;
}

std::uint64_t largest_allocation(VkPhysicalDevice device) {
    VkPhysicalDeviceMaintenance3Properties limits{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                           .pNext = &limits};
    vkGetPhysicalDeviceProperties2(device, &properties);
    return limits.maxMemoryAllocationSize;
}

}  // namespace

Device::Device(const Instance& instance, const std::string& wish) {
    choose(instance, wish);
    create();
}

void Device::choose(const Instance& instance, const std::string& wish) {
    const auto devices = instance.devices();
    std::string seen, unfit;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const auto properties = properties_of(devices[i]);
        seen += (seen.empty() ? "" : ", ") + std::to_string(i) + ": " + properties.deviceName;
        if (!wish.empty() && !fulfils(wish, i, properties.deviceName)) continue;
        if (const auto lack = shortcoming(devices[i]); !lack.empty()) {
            unfit += (unfit.empty() ? "" : ", ") + std::string(properties.deviceName) + " lacks " + lack;
        } else if (physical_ == VK_NULL_HANDLE ||
                   rank(properties.deviceType) < rank(properties_.deviceType)) {
            physical_ = devices[i];
            properties_ = properties;
        }
    }
    if (physical_ != VK_NULL_HANDLE) return;
    if (devices.empty()) throw Error(ErrorCode::unsupported, "Vulkan: no device; is a driver installed?");
    if (!unfit.empty()) throw Error(ErrorCode::unsupported, "Vulkan: no usable device: " + unfit);
    throw Error(ErrorCode::usage, "Vulkan: no device '" + wish + "'; there are " + seen);
}

void Device::create() {
    max_allocation_ = largest_allocation(physical_);
    family_ = *graphics_family(physical_);
    timestamp_bits_ =
        enumerate<VkQueueFamilyProperties>(vkGetPhysicalDeviceQueueFamilyProperties, physical_)[family_]
            .timestampValidBits;

    Features there, wanted;
    vkGetPhysicalDeviceFeatures2(physical_, &there.base);
    // gl_PrimitiveID in a fragment shader hangs on this feature; no geometry shader is used.
    primitive_numbers_ = there.base.features.geometryShader == VK_TRUE;
    wanted.base.features.geometryShader = there.base.features.geometryShader;
    wanted.base.features.shaderInt64 = VK_TRUE;
    wanted.base.features.multiDrawIndirect = VK_TRUE;
    wanted.base.features.drawIndirectFirstInstance = VK_TRUE;
    wanted.v12.timelineSemaphore = VK_TRUE;
    wanted.v13.dynamicRendering = VK_TRUE;
    wanted.v13.maintenance4 = VK_TRUE;  // work group sizes by constant; every Vulkan 1.3 device has it
    wanted.v13.synchronization2 = VK_TRUE;
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                        .queueFamilyIndex = family_,
                                        .queueCount = 1,
                                        .pQueuePriorities = &priority};
    const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                  .pNext = &wanted.base,
                                  .queueCreateInfoCount = 1,
                                  .pQueueCreateInfos = &queue};
    check(vkCreateDevice(physical_, &info, nullptr, &device_), "creating a device on " + name());
    vkGetDeviceQueue(device_, family_, 0, &queue_);

    const VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                       .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                       .queueFamilyIndex = family_};
    VkCommandPool pool_handle = VK_NULL_HANDLE;
    check(vkCreateCommandPool(device_, &pool, nullptr, &pool_handle), "creating a command pool");
    pool_ = {device_, pool_handle};

    const VkSemaphoreTypeCreateInfo type{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                         .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    const VkSemaphoreCreateInfo semaphore{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
    VkSemaphore semaphore_handle = VK_NULL_HANDLE;
    check(vkCreateSemaphore(device_, &semaphore, nullptr, &semaphore_handle),
          "creating a timeline semaphore");
    timeline_ = {device_, semaphore_handle};
}

Device::~Device() {
    vkDeviceWaitIdle(device_);
    timeline_ = {};
    pool_ = {};
    vkDestroyDevice(device_, nullptr);
}

std::uint64_t Device::timestamp_mask() const {
    return timestamp_bits_ >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << timestamp_bits_) - 1;
}

VkCommandBuffer Device::new_commands() const {
    const VkCommandBufferAllocateInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                           .commandPool = pool_.get(),
                                           .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                           .commandBufferCount = 1};
    VkCommandBuffer commands = VK_NULL_HANDLE;
    check(vkAllocateCommandBuffers(device_, &info, &commands), "allocating a command buffer");
    return commands;
}

void Device::free_commands(VkCommandBuffer commands) const {
    vkFreeCommandBuffers(device_, pool_.get(), 1, &commands);
}

void Device::begin(VkCommandBuffer commands) const {
    const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    check(vkBeginCommandBuffer(commands, &info), "beginning a command buffer");
}

std::uint64_t Device::submit(VkCommandBuffer commands) {
    check(vkEndCommandBuffer(commands), "ending a command buffer");
    const VkCommandBufferSubmitInfo buffer{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                           .commandBuffer = commands};
    const VkSemaphoreSubmitInfo signal{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                       .semaphore = timeline_.get(),
                                       .value = submitted_ + 1,
                                       .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
    const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                             .commandBufferInfoCount = 1,
                             .pCommandBufferInfos = &buffer,
                             .signalSemaphoreInfoCount = 1,
                             .pSignalSemaphoreInfos = &signal};
    check(vkQueueSubmit2(queue_, 1, &info, VK_NULL_HANDLE), "submitting work");
    return ++submitted_;
}

void Device::wait(std::uint64_t value) const {
    const VkSemaphoreWaitInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                   .semaphoreCount = 1,
                                   .pSemaphores = timeline_.address(),
                                   .pValues = &value};
    check(vkWaitSemaphores(device_, &info, ~std::uint64_t{0}), "waiting for the device");
}

bool Device::done(std::uint64_t value) const {
    std::uint64_t reached = 0;
    check(vkGetSemaphoreCounterValue(device_, timeline_.get(), &reached), "reading the timeline");
    return reached >= value;
}

void Device::wait_idle() const { check(vkDeviceWaitIdle(device_), "waiting for the device"); }

namespace {

constexpr VkAccessFlags2 kAnyAccess = VK_ACCESS_2_MEMORY_WRITE_BIT | VK_ACCESS_2_MEMORY_READ_BIT;

void barrier(VkCommandBuffer commands, VkPipelineStageFlags2 after, VkAccessFlags2 access) {
    const VkMemoryBarrier2 memory{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                  .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                  .srcAccessMask = kAnyAccess,
                                  .dstStageMask = after,
                                  .dstAccessMask = access};
    const VkDependencyInfo info{
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &memory};
    vkCmdPipelineBarrier2(commands, &info);
}

}  // namespace

void full_barrier(VkCommandBuffer commands) {
    barrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, kAnyAccess);
}

void host_barrier(VkCommandBuffer commands) {
    barrier(commands, VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
}

}  // namespace carat::vk
