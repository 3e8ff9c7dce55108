#include "pixels.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <glm/gtc/packing.hpp>

namespace carat {

namespace {

const std::array<float, 65536>& half_values() {
    static const auto values = [] {
        std::array<float, 65536> v{};
        for (std::uint32_t h = 0; h < v.size(); ++h)
            v[h] = glm::unpackHalf1x16(static_cast<std::uint16_t>(h));
        return v;
    }();
    return values;
}

}  // namespace

Picture empty_picture(int width, int height, std::vector<std::string> channels) {
    Picture p{width, height, std::move(channels), {}, {}};
    p.values.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * p.channels.size());
    return p;
}

void take_half4(Picture& picture, std::size_t first, std::size_t count, const std::byte* pixels) {
    const auto& value = half_values();
    float* out = picture.values.data() + first * 4;
    for (std::size_t i = 0; i < count * 4; ++i) {
        std::uint16_t half;
        std::memcpy(&half, pixels + i * sizeof(half), sizeof(half));
        out[i] = value[half];
    }
}

void take_float4(Picture& picture, std::size_t first, std::size_t count, const std::byte* pixels,
                 std::size_t offset) {
    const std::size_t channels = picture.channels.size();
    float* out = picture.values.data() + first * channels;
    for (std::size_t i = 0; i < count; ++i) {
        std::memcpy(out + i * channels, pixels + (i * 4 + offset) * sizeof(float), channels * sizeof(float));
    }
}

}  // namespace carat
