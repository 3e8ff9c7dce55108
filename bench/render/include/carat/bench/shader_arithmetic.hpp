// What the vertex shader computes, operation by operation (render/vulkan/shaders/position.glsl), without a
// GPU. A test compares it with the shader's own results, bit for bit.
#pragma once

#include <array>
#include <cstdint>

#include "carat/render/patch_mesh.hpp"

namespace carat::bench {

// Axes and unit as the shader gets them.
struct ShaderCamera {
    UnitVector eye{};                            // length units
    std::array<std::array<float, 3>, 3> axes{};  // right, up, forward
    float metres_per_unit = 0;

    ShaderCamera(const Camera& camera, double unit)
        : eye(camera.eye), metres_per_unit(static_cast<float>(unit)) {
        const std::array<const Vec3*, 3> from{&camera.right, &camera.up, &camera.forward};
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t k = 0; k < 3; ++k) axes[a][k] = static_cast<float>((*from[a])[k]);
    }
};

inline float shader_metres(std::int64_t units, float metres_per_unit) {
    const std::uint64_t magnitude =
        units < 0 ? 0 - static_cast<std::uint64_t>(units) : static_cast<std::uint64_t>(units);
    const float high = static_cast<float>(static_cast<std::uint32_t>(magnitude >> 32)) * 4294967296.0f;
    const float value = (high + static_cast<float>(static_cast<std::uint32_t>(magnitude))) * metres_per_unit;
    return units < 0 ? -value : value;
}

// Metres along right, up and forward from the eye; forward is w of the clip position.
inline std::array<float, 3> shader_position(const ShaderCamera& camera, const UnitVector& vertex) {
    std::array<float, 3> p{}, out{};
    for (std::size_t k = 0; k < 3; ++k)
        p[k] = shader_metres(vertex[k] - camera.eye[k], camera.metres_per_unit);
    for (std::size_t a = 0; a < 3; ++a)
        out[a] = camera.axes[a][0] * p[0] + camera.axes[a][1] * p[1] + camera.axes[a][2] * p[2];
    return out;
}

// Reversed depth as the device stores it.
inline float shader_depth(float forward, float near_plane) { return near_plane / forward; }

}  // namespace carat::bench
