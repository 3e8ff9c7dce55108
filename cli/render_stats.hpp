// What a picture cost.
#pragma once

#include <cstdint>
#include <string>

#include "carat/render/cut.hpp"
#include "carat/render/shadows.hpp"
#include "carat/vulkan/renderer.hpp"

namespace carat::cli {

struct RenderStats {
    std::string device;
    Camera camera;
    double unit = 0;  // metres, of the camera's eye
    CutCounters cut;
    FrameCounters frame;
    ShadowCounters shadows;
    std::uint64_t file_bytes = 0;
    double seconds = 0;  // of the whole command

    // One line.
    std::string summary() const;
    // As JSON. Throws Error(io).
    void write(const std::string& path) const;
};

}  // namespace carat::cli
