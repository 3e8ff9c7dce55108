#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared.h"
layout(std430, set = 0, binding = kBindFrame) readonly buffer Frame { FrameData frame; };
#include "surface.glsl"

// At a covered sample, not at a pixel centre that a triangle smaller than a pixel may miss by a multiple of its size. With one
// sample a pixel both are the same.
layout(location = 0) centroid in vec3 in_relative;
layout(location = 1) centroid in vec3 in_normal;
layout(location = 2) centroid in vec3 in_up;
layout(location = 3) centroid in float in_height;
layout(location = 4) flat in uvec2 in_patch;
layout(location = 5) centroid in vec3 in_tint;
layout(location = 6) centroid in float in_sun;
layout(location = 7) centroid in float in_one;

#ifdef CARAT_COLOUR
layout(location = 0) out vec4 out_colour;  // linear, alpha 1
#endif
#ifdef CARAT_AOV
layout(location = AOV_FIRST) out vec4 out_position;    // relative to the eye, body axes, metres; w: depth along forward
layout(location = AOV_FIRST + 1) out vec4 out_normal;  // unit; w: height, metres
layout(location = AOV_FIRST + 2) out uvec4 out_patch;  // half, number of the triangle drawn
#endif

void main() {
#ifdef CARAT_COLOUR
    // 1, and what is divided by it left as it is, but on devices that divide what they interpolate at a covered sample
    // by the depth of the pixel's centre (llvmpipe of Mesa 22.3): with ground seen at a low angle that is a tenth off.
    float one = in_one;
    out_colour = vec4(surface_colour(in_normal, in_up, in_height / one, in_relative / one, in_tint / one,
                                     kShadows ? in_sun / one : 1.0), 1.0);
#endif
#ifdef CARAT_AOV
    out_position = vec4(in_relative, dot(frame.forward.xyz, in_relative));
    out_normal = vec4(normalize(in_normal), in_height);
    out_patch = uvec4(in_patch, gl_PrimitiveID, 0u);
#endif
}
