#include "shaders.hpp"

#include "probe.h"
#include "terrain_aov.h"
#include "terrain_colour.h"
#include "terrain_colour_aov.h"
#include "terrain_vertex.h"

namespace carat::vk {

const Spirv kTerrainVertex{terrain_vertex};
const Spirv kTerrainColour{terrain_colour};
const Spirv kTerrainColourAov{terrain_colour_aov};
const Spirv kTerrainAov{terrain_aov};
const Spirv kProbe{probe};

}  // namespace carat::vk
