#include "check.hpp"

namespace carat::vk {

const char* result_name(VkResult result) {
    switch (result) {
        case VK_SUCCESS:
            return "success";
        case VK_ERROR_OUT_OF_HOST_MEMORY:
            return "out of host memory";
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
            return "out of device memory";
        case VK_ERROR_INITIALIZATION_FAILED:
            return "initialisation failed";
        case VK_ERROR_DEVICE_LOST:
            return "device lost";
        case VK_ERROR_MEMORY_MAP_FAILED:
            return "memory cannot be mapped";
        case VK_ERROR_LAYER_NOT_PRESENT:
            return "layer not present";
        case VK_ERROR_EXTENSION_NOT_PRESENT:
            return "extension not present";
        case VK_ERROR_FEATURE_NOT_PRESENT:
            return "feature not present";
        case VK_ERROR_INCOMPATIBLE_DRIVER:
            return "no compatible driver";
        case VK_ERROR_TOO_MANY_OBJECTS:
            return "too many objects";
        case VK_TIMEOUT:
            return "timeout";
        default:
            return "unexpected result";
    }
}

namespace {

ErrorCode code_of(VkResult result) {
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY:
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        case VK_ERROR_TOO_MANY_OBJECTS:
            return ErrorCode::limit;
        case VK_ERROR_LAYER_NOT_PRESENT:
        case VK_ERROR_EXTENSION_NOT_PRESENT:
        case VK_ERROR_FEATURE_NOT_PRESENT:
        case VK_ERROR_INCOMPATIBLE_DRIVER:
            return ErrorCode::unsupported;
        default:
            return ErrorCode::io;
    }
}

}  // namespace

void check(VkResult result, const std::string& what) {
    if (result == VK_SUCCESS) return;
    throw Error(code_of(result),
                "Vulkan: " + what + ": " + result_name(result) + " (" + std::to_string(int(result)) + ")");
}

}  // namespace carat::vk
