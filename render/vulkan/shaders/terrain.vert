#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared.h"
#include "position.glsl"

layout(location = 0) out vec3 out_relative;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out vec3 out_up;
layout(location = 3) out float out_height;
layout(location = 4) flat out uvec2 out_patch;
layout(location = 5) out vec3 out_tint;  // linear
layout(location = 6) out float out_sun;  // share of it that is seen
layout(location = 7) out float out_one;  // 1, unknown to the compiler

layout(constant_id = 2) const bool kDrape = false;
layout(constant_id = 3) const bool kShadows = false;
layout(std430, set = 0, binding = kBindColours) readonly buffer Colours { uint colours[]; };

invariant gl_Position;

vec3 octahedral(vec2 e) {
    vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    float fold = max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -fold : fold;
    n.y += n.y >= 0.0 ? -fold : fold;
    return normalize(n);
}

vec3 linear_of(vec3 encoded) {
    return mix(encoded / 12.92, pow((encoded + 0.055) / 1.055, vec3(2.4)), greaterThan(encoded, vec3(0.04045)));
}

void main() {
    VertexData v = vertices[gl_VertexIndex];
    PatchData p = patches[gl_InstanceIndex];
    vec3 relative = relative_to_eye(p, v);
    gl_Position = clip_position(relative);
    out_relative = relative;
    out_normal = octahedral(unpackSnorm2x16(v.normal));
    out_up = normalize((relative + frame.eye.xyz) * frame.body.xyz);
    out_height = v.height;
    out_tint = kDrape ? linear_of(unpackUnorm4x8(colours[gl_VertexIndex]).rgb) : vec3(0.0);
    out_sun = kShadows ? unpackUnorm4x8(colours[gl_VertexIndex]).a : 1.0;
    out_one = frame.body.x;
    out_patch = uvec2(p.id_low, p.id_high);
}
