#include "instance.hpp"

#include <algorithm>
#include <cstring>

namespace carat::vk {

namespace {

constexpr const char* kLayer = "VK_LAYER_KHRONOS_validation";

template <class Function>
Function load(VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

void require_layer() {
    const auto layers = enumerate<VkLayerProperties>(vkEnumerateInstanceLayerProperties);
    const bool found = std::any_of(layers.begin(), layers.end(), [](const auto& layer) {
        return std::strcmp(layer.layerName, kLayer) == 0;
    });
    if (!found)
        throw Error(ErrorCode::unsupported, std::string("Vulkan: the layer ") + kLayer + " is not installed");
}

}  // namespace

VkBool32 Instance::listen(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                          const VkDebugUtilsMessengerCallbackDataEXT* data, void* log) {
    auto& l = *static_cast<Log*>(log);
    const std::lock_guard lock(l.mutex);
    l.messages.emplace_back(data->pMessage);
    return VK_FALSE;
}

Instance::Instance(bool validation) {
    const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                        .pApplicationName = "carat",
                                        .pEngineName = "carat",
                                        .apiVersion = VK_API_VERSION_1_3};
    const VkDebugUtilsMessengerCreateInfoEXT listener{
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity =
            VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType =
            VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
        .pfnUserCallback = listen,
        .pUserData = log_.get()};
    // Accesses of earlier submissions are part of our promises, so hazards are looked for as well.
    const VkValidationFeatureEnableEXT synchronisation =
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkValidationFeaturesEXT features{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                           .pNext = &listener,
                                           .enabledValidationFeatureCount = 1,
                                           .pEnabledValidationFeatures = &synchronisation};
    const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                              .pApplicationInfo = &application};
    if (validation) {
        require_layer();
        info.pNext = &features;
        info.enabledLayerCount = info.enabledExtensionCount = 1;
        info.ppEnabledLayerNames = &kLayer;
        info.ppEnabledExtensionNames = &extension;
    }
    check(vkCreateInstance(&info, nullptr, &instance_), "creating an instance");
    if (validation) {
        const auto create =
            load<PFN_vkCreateDebugUtilsMessengerEXT>(instance_, "vkCreateDebugUtilsMessengerEXT");
        check(create(instance_, &listener, nullptr, &messenger_), "listening to the validation layer");
    }
}

Instance::~Instance() {
    if (messenger_ != VK_NULL_HANDLE) {
        load<PFN_vkDestroyDebugUtilsMessengerEXT>(instance_, "vkDestroyDebugUtilsMessengerEXT")(
            instance_, messenger_, nullptr);
    }
    vkDestroyInstance(instance_, nullptr);
}

std::vector<VkPhysicalDevice> Instance::devices() const {
    return enumerate<VkPhysicalDevice>(vkEnumeratePhysicalDevices, instance_);
}

std::vector<std::string> Instance::messages() const {
    const std::lock_guard lock(log_->mutex);
    return log_->messages;
}

}  // namespace carat::vk
