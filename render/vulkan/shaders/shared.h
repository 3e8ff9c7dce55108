// Layouts and constants shared by C++ and GLSL: both include this file. std430; every member is named once.
#ifndef CARAT_SHADERS_SHARED_H
#define CARAT_SHADERS_SHARED_H

#ifdef __cplusplus
#include <cstdint>
namespace carat::gpu {
using std::int64_t;
using uint = std::uint32_t;
struct vec4 {
    float x, y, z, w;
};
#define CARAT_CONST constexpr uint
#else
#define CARAT_CONST const uint
#endif

// Bindings of the one descriptor set.
CARAT_CONST kBindFrame = 0;     // FrameData
CARAT_CONST kBindVertices = 1;  // VertexData[], one chunk of slots
CARAT_CONST kBindPatches = 2;   // PatchData[], one a slot of the chunk
CARAT_CONST kBindTable = 3;     // colour table, layer 0 below the sea level, layer 1 above
CARAT_CONST kBindProbe = 4;     // vec4[], clip positions written by probe.comp

CARAT_CONST kBindTransmittance = 5;  // of the air, to its top (air.glsl)
CARAT_CONST kBindMultiple = 6;       // light scattered more than once
CARAT_CONST kBindAirOut = 7;         // image that air_tables.comp writes
CARAT_CONST kBindSkyLight = 8;       // irradiance of the sky on level ground
CARAT_CONST kBindColours = 9;        // uint[], sRGB of the vertices of the chunk's slots

CARAT_CONST kTableHeights = 2048;   // texels along height: 10 m each on Earth, linear between
CARAT_CONST kTableLatitudes = 181;  // texels along latitude, one a degree from the south pole
CARAT_CONST kProbeGroup = 64;       // work group of probe.comp

// Texels of the air's tables. Cosines of the sun's zenith angle run from -1 to 1, heights by their square root.
CARAT_CONST kTransmittanceCosines = 256;
CARAT_CONST kTransmittanceHeights = 64;
CARAT_CONST kMultipleCosines = 32;
CARAT_CONST kMultipleHeights = 32;
CARAT_CONST kSkyLightCosines = 128;
CARAT_CONST kSkyLightHeights = 8;
CARAT_CONST kAirGroup = 8;   // work group of air_tables.comp, a side
CARAT_CONST kAirSteps = 16;  // along a ray of a picture

// One vertex: the bytes of carat::PatchVertex.
struct VertexData {
    int64_t x, y, z;  // from the patch's anchor, length units
    uint normal;      // octahedral, two snorm16
    float height;     // metres
};

// One patch slot.
struct PatchData {
    int64_t x, y, z;  // anchor, length units
    uint id_low;      // DiamondId * 2 + side
    uint id_high;
};

// The air, in metres and 1/m for red, green and blue.
struct AirData {
    vec4 rayleigh;        // scattering at the ground; w: 1 / scale height
    vec4 mie;             // the same of aerosols
    vec4 mie_extinction;  // w: asymmetry
    vec4 absorber;        // absorption at the middle of its layer; w: height of the middle
    vec4 shell;           // radius of the ground, height of the top, stretch a/b of the polar axis, half width of the absorber
    float shell_sun;      // the sun's angular radius, radians
    float ground;         // albedo, for light scattered more than once
    float multiple;       // 0: single scattering alone
    float unused;
};

// What is constant over a frame. Axes and directions are unit vectors in the body frame.
struct FrameData {
    int64_t eye_x, eye_y, eye_z;  // length units
    float metres_per_unit;
    float near_plane;  // metres along forward
    vec4 right;        // w: clip units per unit slope, horizontally
    vec4 up;           // w: the same vertically
    vec4 forward;
    vec4 light;   // towards the light; w: ambient share
    vec4 body;    // a^2/a^2, a^2/a^2, a^2/b^2: position to normal; w: exposure
    vec4 table;   // lowest sea height, sea level, highest land height, metres; w: relief exaggeration
    vec4 eye;     // position, metres, rounded; w: variance of the slopes of waves
    // Stretched along the polar axis by a/b, then unit.
    vec4 eye_up;      // the eye's position; w: its height, metres
    vec4 sun;         // towards the light; w: unused
    vec4 background;  // linear; w: angle of a pixel, radians
    AirData air;
};

#ifdef __cplusplus
static_assert(sizeof(VertexData) == 32 && sizeof(PatchData) == 32 && sizeof(FrameData) == 288);
}  // namespace carat::gpu
#endif
#undef CARAT_CONST

#endif
