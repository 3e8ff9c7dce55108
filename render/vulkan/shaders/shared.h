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

CARAT_CONST kTableHeights = 2048;   // texels along height: 10 m each on Earth, linear between
CARAT_CONST kTableLatitudes = 181;  // texels along latitude, one a degree from the south pole
CARAT_CONST kProbeGroup = 64;       // work group of probe.comp

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
    vec4 eye;     // position, metres, rounded
};

#ifdef __cplusplus
static_assert(sizeof(VertexData) == 32 && sizeof(PatchData) == 32 && sizeof(FrameData) == 144);
}  // namespace carat::gpu
#endif
#undef CARAT_CONST

#endif
