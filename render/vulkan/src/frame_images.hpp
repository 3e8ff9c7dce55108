// Which images of the targets a request reads, and how their pixels become the pictures of a Frame.
#pragma once

#include <vector>

#include "carat/vulkan/renderer.hpp"
#include "readback.hpp"
#include "targets.hpp"

namespace carat {

// Makes the frame's pictures and says how to fill them; `frame` must stay where it is until they are filled.
std::vector<vk::ImageRead> frame_images(const DrawRequest& request, const vk::Targets& targets, Frame& frame);

}  // namespace carat
