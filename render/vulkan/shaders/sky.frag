// What is seen where there is no terrain: the sky, the sun's disc, and the sea between the horizon of its floor and its own.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared.h"
layout(std430, set = 0, binding = kBindFrame) readonly buffer Frame { FrameData frame; };
#include "surface.glsl"

layout(location = 0) in vec2 in_screen;
layout(location = 0) out vec4 out_colour;

// A sea floor that no ray reaches: half as deep as the deepest.
vec4 distant_sea(vec3 way) {
    Sight sight = sight_along(way, 1e30);
    if (!meets_sea(sight)) return vec4(0.0);
    sight = sight_to(sight, sea_distance(sight));
    float depth = 0.5 * (frame.table.x + frame.table.y);
    vec3 body = sea_albedo(depth, normalize(vertical_at_end(sight) * vec3(1.0, 1.0, AIR.shell.z)));
    return vec4(through_air(sight, water_colour(sight, body)) * frame.body.w, 1.0);
}

void main() {
    vec3 way = normalize(frame.forward.xyz + frame.right.xyz * (in_screen.x / frame.right.w) -
                         frame.up.xyz * (in_screen.y / frame.up.w));
    vec4 colour = vec4(frame.background.rgb, 0.0);
    vec4 sea = kWater ? distant_sea(way) : vec4(0.0);
    if (sea.a > 0.0) {
        colour = sea;
    } else if (kSky) {
        Sight sight = sight_along(way, 1e30);
        vec2 ground = crossings(sight.ray, 0.0);
        bool lands = ground.x <= ground.y && ground.x > 0.0;
        if (lands) sight.end = ground.x;
        float off = length(way - frame.light.xyz), radius = AIR.shell_sun;  // small angles
        float disc = lands ? 0.0 : 1.0 - smoothstep(radius, radius + frame.background.w, off);
        vec3 behind = colour.rgb / max(frame.body.w, 1e-9) + vec3(disc / (radius * radius));
        colour.rgb = min(through_air(sight, behind) * frame.body.w, vec3(60000.0));
    }
    out_colour = colour;
}
