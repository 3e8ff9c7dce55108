// A request as the shaders read it.
#pragma once

#include <optional>

#include "carat/vulkan/renderer.hpp"
#include "shared.h"
#include "table_texture.hpp"

namespace carat {

// Throws Error(usage) naming what is wrong with the request.
void check_request(const DrawRequest& request);
// Without an atmosphere the ground's radius and stretch alone are filled.
gpu::AirData make_air_data(const Ellipsoid& body, const std::optional<Atmosphere>& atmosphere);
gpu::FrameData make_frame_data(const DrawRequest& request, const Ellipsoid& body, double metres_per_unit,
                               const vk::TableTexture& table, const gpu::AirData& air);

}  // namespace carat
