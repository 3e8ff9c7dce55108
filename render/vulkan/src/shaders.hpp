// The shaders, compiled by the build.
#pragma once

#include <cstdint>
#include <span>

namespace carat::vk {

using Spirv = std::span<const std::uint32_t>;

extern const Spirv kTerrainVertex;
extern const Spirv kTerrainColour;     // writes colour
extern const Spirv kTerrainColourAov;  // colour and AOVs
extern const Spirv kTerrainAov;        // AOVs only
extern const Spirv kProbe;
extern const Spirv kAirTables;
extern const Spirv kSkyVertex;
extern const Spirv kSkyFragment;

}  // namespace carat::vk
