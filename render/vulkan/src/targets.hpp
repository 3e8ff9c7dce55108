// The images that are drawn into.
#pragma once

#include <array>
#include <optional>

#include "memory.hpp"
#include "pipelines.hpp"

namespace carat::vk {

struct TargetWish {
    VkExtent2D extent{};
    VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
    bool aovs = false;

    friend bool operator==(const TargetWish& l, const TargetWish& r) {
        return l.extent.width == r.extent.width && l.extent.height == r.extent.height &&
               l.samples == r.samples && l.aovs == r.aovs;
    }
};

// Colour with one or more samples a pixel, and AOVs with one: in the same pass where colour has one sample
// too, in a pass of their own otherwise, because an averaged position is no position.
class Targets {
  public:
    // Throws Error(limit) when the picture is larger than the device can draw or than its memory.
    Targets(const Device& device, const TargetWish& wish);

    const TargetWish& wish() const { return wish_; }
    std::vector<PassKind> passes(bool cull_back_faces) const;

    // Before the first batch: layouts for drawing, old contents dropped.
    void prepare(VkCommandBuffer commands) const;
    // Begins drawing a pass: `first` clears, `last` makes the final colours.
    void begin(VkCommandBuffer commands, const PassKind& pass, const std::array<float, 3>& background,
               bool first, bool last) const;
    // After the last batch: layouts for reading back.
    void finish(VkCommandBuffer commands) const;

    const Image& colour() const { return colour_; }
    const Image& position() const { return *position_; }
    const Image& normal() const { return *normal_; }
    const Image& patch() const { return *patch_; }

  private:
    std::vector<const Image*> readable() const;
    std::vector<const Image*> all() const;

    TargetWish wish_;
    Image colour_, depth_;
    std::optional<Image> samples_;                    // where several samples are averaged into colour_
    std::optional<Image> position_, normal_, patch_;  // AOVs
    std::optional<Image> aov_depth_;                  // where AOVs have a pass of their own
};

// The greatest number of samples that the device supports and that is not above `wanted`.
VkSampleCountFlagBits supported_samples(const Device& device, int wanted);

}  // namespace carat::vk
