#include "shaders.hpp"

#include "air_tables.h"
#include "probe.h"
#include "sky_fragment.h"
#include "sky_vertex.h"
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
const Spirv kAirTables{air_tables};
const Spirv kSkyVertex{sky_vertex};
const Spirv kSkyFragment{sky_fragment};

}  // namespace carat::vk
