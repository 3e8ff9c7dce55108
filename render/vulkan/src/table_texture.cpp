#include "table_texture.hpp"

#include <algorithm>
#include <cstring>
#include <glm/gtc/packing.hpp>

#include "shared.h"

namespace carat::vk {

namespace {

constexpr std::uint32_t kHeights = gpu::kTableHeights, kLatitudes = gpu::kTableLatitudes;

struct Range {
    double low, high;
};

Range range_of(const std::vector<ColourBand>& bands) {
    Range r{bands[0].stops.front().height, bands[0].stops.back().height};
    for (const auto& band : bands) {
        r.low = std::min(r.low, band.stops.front().height);
        r.high = std::max(r.high, band.stops.back().height);
    }
    return r;
}

// Texel (i, j) is the colour at an exact height and latitude; the sampler interpolates between them in linear
// light.
void fill_layer(const ColourTable& table, Range heights, std::uint64_t* texels) {
    for (std::uint32_t j = 0; j < kLatitudes; ++j) {
        const double latitude = -90 + 180.0 * j / (kLatitudes - 1);
        for (std::uint32_t i = 0; i < kHeights; ++i) {
            const double height = heights.low + (heights.high - heights.low) * i / (kHeights - 1);
            const auto c = colour_at(table, latitude, height);
            texels[j * kHeights + i] = glm::packHalf4x16(glm::vec4(c[0], c[1], c[2], 1));
        }
    }
}

// One side of the sea level as a table without a sea.
ColourTable layer_table(const ColourTable& table, bool sea) {
    return {table.name, std::nullopt, {}, sea ? table.sea : table.land};
}

void upload(Device& device, const Image& image, const Buffer& staging) {
    const VkCommandBuffer commands = device.new_commands();
    device.begin(commands);
    change_layout(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    const VkBufferImageCopy region{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 2},
                                   .imageExtent = {kHeights, kLatitudes, 1}};
    vkCmdCopyBufferToImage(commands, staging.handle.get(), image.handle.get(),
                           VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    change_layout(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                  VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    device.wait(device.submit(commands));
    device.free_commands(commands);
}

}  // namespace

TableTexture make_table_texture(Device& device, const ColourTable& table) {
    check_colours(table);
    const Range land = range_of(table.land);
    const Range sea = table.sea_level ? range_of(table.sea) : Range{land.low - 1, land.low};
    TableTexture texture;
    texture.has_sea = table.sea_level.has_value();
    // The land's layer starts at the sea level, or at its lowest stop where there is no sea.
    texture.sea_level = static_cast<float>(table.sea_level.value_or(land.low));
    texture.sea_floor = static_cast<float>(std::min(sea.low, double(texture.sea_level) - 1));
    texture.top = static_cast<float>(std::max(land.high, double(texture.sea_level) + 1));

    const std::size_t layer = std::size_t{kHeights} * kLatitudes;
    std::vector<std::uint64_t> texels(2 * layer);
    fill_layer(layer_table(table, table.sea_level.has_value()), {texture.sea_floor, texture.sea_level},
               texels.data());
    fill_layer(layer_table(table, false), {texture.sea_level, texture.top}, texels.data() + layer);

    texture.image = make_image(device, {{kHeights, kLatitudes},
                                        VK_FORMAT_R16G16B16A16_SFLOAT,
                                        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                        VK_SAMPLE_COUNT_1_BIT,
                                        2,
                                        "a colour table"});
    const std::size_t bytes = texels.size() * sizeof(texels[0]);
    const Buffer staging =
        make_buffer(device, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Where::upload, "a colour table");
    std::memcpy(staging.mapped, texels.data(), bytes);
    upload(device, texture.image, staging);
    return texture;
}

Sampler make_table_sampler(const Device& device) {
    const VkSamplerCreateInfo info{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                   .magFilter = VK_FILTER_LINEAR,
                                   .minFilter = VK_FILTER_LINEAR,
                                   .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                   .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                   .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    VkSampler sampler = VK_NULL_HANDLE;
    check(vkCreateSampler(device.get(), &info, nullptr, &sampler), "creating a sampler");
    return {device.get(), sampler};
}

}  // namespace carat::vk
