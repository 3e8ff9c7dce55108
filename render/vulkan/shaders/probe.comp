// Clip positions of one patch's vertices, from the same functions as terrain.vert.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared.h"
#include "position.glsl"

layout(local_size_x = kProbeGroup) in;
layout(std430, set = 0, binding = kBindProbe) writeonly buffer Probe { vec4 clip_positions[]; };
layout(push_constant) uniform Range {
    uint slot;
    uint vertex_count;
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < vertex_count) {
        clip_positions[i] = clip_position(relative_to_eye(patches[slot], vertices[slot * vertex_count + i]));
    }
}
