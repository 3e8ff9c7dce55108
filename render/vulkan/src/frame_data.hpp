// A request as the shaders read it.
#pragma once

#include "carat/vulkan/renderer.hpp"
#include "shared.h"
#include "table_texture.hpp"

namespace carat {

// Throws Error(usage) naming what is wrong with the request.
void check_request(const DrawRequest& request);
gpu::FrameData make_frame_data(const DrawRequest& request, const Ellipsoid& body, double metres_per_unit,
                               const vk::TableTexture& table);

}  // namespace carat
