#include "targets.hpp"

#include <algorithm>

namespace carat::vk {

namespace {

constexpr VkImageUsageFlags kAttachment = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
constexpr VkImageUsageFlags kDepthAttachment = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;

void check_size(const Device& device, VkExtent2D extent) {
    const auto& limits = device.properties().limits;
    const std::uint32_t width =
        std::min({limits.maxImageDimension2D, limits.maxFramebufferWidth, limits.maxViewportDimensions[0]});
    const std::uint32_t height =
        std::min({limits.maxImageDimension2D, limits.maxFramebufferHeight, limits.maxViewportDimensions[1]});
    if (extent.width <= width && extent.height <= height) return;
    throw Error(ErrorCode::limit, "a picture of " + std::to_string(extent.width) + "x" +
                                      std::to_string(extent.height) + " pixels: " + device.name() +
                                      " draws at most " + std::to_string(width) + "x" +
                                      std::to_string(height));
}

VkRenderingAttachmentInfo attachment(const Image& image, VkImageLayout layout, bool clear) {
    return {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
            .imageView = image.view.get(),
            .imageLayout = layout,
            .loadOp = clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD,
            .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
}

VkRenderingAttachmentInfo colour_attachment(const Image& image, bool clear) {
    return attachment(image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, clear);
}

}  // namespace

VkSampleCountFlagBits supported_samples(const Device& device, int wanted) {
    const auto& limits = device.properties().limits;
    const VkSampleCountFlags both = limits.framebufferColorSampleCounts & limits.framebufferDepthSampleCounts;
    for (const auto count : {VK_SAMPLE_COUNT_8_BIT, VK_SAMPLE_COUNT_4_BIT, VK_SAMPLE_COUNT_2_BIT}) {
        if (static_cast<int>(count) <= wanted && (both & count) != 0) return count;
    }
    return VK_SAMPLE_COUNT_1_BIT;
}

Targets::Targets(const Device& device, const TargetWish& wish) : wish_(wish) {
    check_size(device, wish.extent);
    const bool several = wish.samples != VK_SAMPLE_COUNT_1_BIT;
    const auto make = [&](VkFormat format, VkImageUsageFlags usage, VkSampleCountFlagBits samples,
                          const char* what) {
        return make_image(device, {wish.extent, format, usage, samples, 1, what});
    };
    const VkImageUsageFlags readable = kAttachment | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    colour_ = make(kColourFormat, readable, VK_SAMPLE_COUNT_1_BIT, "colour");
    depth_ = make(kDepthFormat, kDepthAttachment, wish.samples, "depth");
    if (several) samples_ = make(kColourFormat, kAttachment, wish.samples, "colour samples");
    if (!wish.aovs) return;
    position_ = make(kPositionFormat, readable, VK_SAMPLE_COUNT_1_BIT, "positions");
    normal_ = make(kNormalFormat, readable, VK_SAMPLE_COUNT_1_BIT, "normals");
    patch_ = make(kPatchFormat, readable, VK_SAMPLE_COUNT_1_BIT, "patch numbers");
    if (several) aov_depth_ = make(kDepthFormat, kDepthAttachment, VK_SAMPLE_COUNT_1_BIT, "depth");
}

std::vector<PassKind> Targets::passes(bool cull) const {
    const bool together = wish_.aovs && !samples_;
    std::vector<PassKind> kinds{{true, together, wish_.samples, cull}};
    if (wish_.aovs && !together) kinds.push_back({false, true, VK_SAMPLE_COUNT_1_BIT, cull});
    return kinds;
}

std::vector<const Image*> Targets::readable() const {
    std::vector<const Image*> images{&colour_};
    for (const auto* image : {&position_, &normal_, &patch_}) {
        if (*image) images.push_back(&**image);
    }
    return images;
}

std::vector<const Image*> Targets::all() const {
    auto images = readable();
    images.push_back(&depth_);
    if (samples_) images.push_back(&*samples_);
    if (aov_depth_) images.push_back(&*aov_depth_);
    return images;
}

void Targets::prepare(VkCommandBuffer commands) const {
    for (const Image* image : all()) {
        const bool depth = image->format == kDepthFormat;
        change_layout(
            commands, *image, VK_IMAGE_LAYOUT_UNDEFINED,
            depth ? VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    }
}

void Targets::begin(VkCommandBuffer commands, const PassKind& pass, const std::array<float, 3>& background,
                    bool first, bool last) const {
    std::vector<VkRenderingAttachmentInfo> attachments;
    if (pass.colour) {
        attachments.push_back(colour_attachment(samples_ ? *samples_ : colour_, first));
        attachments.back().clearValue.color = {{background[0], background[1], background[2], 0}};
        if (samples_ && last) {
            attachments.back().resolveMode = VK_RESOLVE_MODE_AVERAGE_BIT;
            attachments.back().resolveImageView = colour_.view.get();
            attachments.back().resolveImageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        }
    }
    if (pass.aovs) {
        attachments.push_back(colour_attachment(*position_, first));
        attachments.push_back(colour_attachment(*normal_, first));
        attachments.push_back(colour_attachment(*patch_, first));
        attachments.back().clearValue.color.uint32[0] = attachments.back().clearValue.color.uint32[1] = ~0u;
    }
    const Image& depth = pass.aovs && aov_depth_ ? *aov_depth_ : depth_;
    const auto depth_info =
        attachment(depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, first);  // cleared to 0: infinity

    const VkRect2D area{{0, 0}, wish_.extent};
    const VkRenderingInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                               .renderArea = area,
                               .layerCount = 1,
                               .colorAttachmentCount = static_cast<std::uint32_t>(attachments.size()),
                               .pColorAttachments = attachments.data(),
                               .pDepthAttachment = &depth_info};
    vkCmdBeginRendering(commands, &info);
    const VkViewport viewport{
        0, 0, static_cast<float>(wish_.extent.width), static_cast<float>(wish_.extent.height), 0, 1};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &area);
}

void Targets::finish(VkCommandBuffer commands) const {
    for (const Image* image : readable()) {
        change_layout(commands, *image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                      VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    }
}

}  // namespace carat::vk
