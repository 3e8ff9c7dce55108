// The atmosphere's tables, computed on the device when first wanted.
#pragma once

#include <array>

#include "memory.hpp"
#include "shared.h"

namespace carat::vk {

class AirTables {
  public:
    // Small images, readable from the start; zero until made.
    explicit AirTables(Device& device);

    // Computes all three, waiting for the device. The device must be idle.
    void make(const gpu::AirData& air);

    // By binding: transmittance, multiple scattering, irradiance; in the layout GENERAL.
    struct View {
        std::uint32_t binding;
        VkImageView view;
    };
    std::array<View, 3> views() const;

  private:
    struct Table {
        std::uint32_t binding;
        Image image;
    };
    void write_set(VkDescriptorSet set, const Table& out, VkSampler sampler) const;

    Device& device_;
    std::array<Table, 3> tables_;
};

}  // namespace carat::vk
