// vulkan: from patches and a camera to a picture. Depends on render's meshes (patch_mesh.hpp) and on globe.
//
//   frame    body-fixed, as in globe/globe.hpp; meshes and cameras in whole units u, int64
//   picture  rows from the top, linear light, Rec. 709 primaries; distances in metres
//   files    PNG and others 8 bits sRGB; OpenEXR linear, half for colour, else float
//   colours  by height and latitude; sRGB stops, interpolated linearly as encoded
//   air      single scattering marched along every ray, higher orders from a table; radiance is linear
//   bounds   pictures up to what the device draws; 2 to 128 cells; any number of patches
//   threads  one thread at a time uses a Renderer; everything else is thread-safe
//
// Needs Vulkan 1.3 with shaderInt64, multiDrawIndirect and drawIndirectFirstInstance; no window system.
#pragma once

#include "carat/vulkan/atmosphere.hpp"
#include "carat/vulkan/colour_table.hpp"
#include "carat/vulkan/picture.hpp"
#include "carat/vulkan/renderer.hpp"
#include "carat/vulkan/seen_points.hpp"
