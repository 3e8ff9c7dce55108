// A colour table as a texture: latitude by height, layer 0 for the sea and layer 1 for the land.
#pragma once

#include "carat/vulkan/colour_table.hpp"
#include "memory.hpp"

namespace carat::vk {

struct TableTexture {
    Image image;
    bool has_sea = false;
    float sea_floor = 0, sea_level = 0, top = 0;  // metres; heights of the layers' ends
};

// Waits for the device.
TableTexture make_table_texture(Device& device, const ColourTable& table);
// Linear along height and latitude, clamped.
Sampler make_table_sampler(const Device& device);

}  // namespace carat::vk
