// The validation layer is heard: without this, clean tests would prove nothing.
#include <gtest/gtest.h>

#include "device.hpp"

namespace carat::vk {

namespace {

TEST(Validation, AWrongCallIsCollected) {
    const Instance instance(true);
    const Device device(instance, "");
    EXPECT_TRUE(instance.messages().empty());
    const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                  .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT};
    VkBuffer buffer = VK_NULL_HANDLE;
    if (vkCreateBuffer(device.get(), &info, nullptr, &buffer) == VK_SUCCESS) {
        vkDestroyBuffer(device.get(), buffer, nullptr);
    }
    ASSERT_FALSE(instance.messages().empty());
    EXPECT_NE(instance.messages()[0].find("VUID-VkBufferCreateInfo-size"), std::string::npos)
        << instance.messages()[0];
}

}  // namespace

}  // namespace carat::vk
