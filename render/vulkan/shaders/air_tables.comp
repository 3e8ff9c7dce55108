// The tables of the atmosphere, one a dispatch: transmittance, higher orders of scattering, and the sky's irradiance.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared.h"

layout(local_size_x = kAirGroup, local_size_y = kAirGroup) in;
layout(constant_id = 0) const uint kTable = 0;  // a binding: which table
layout(set = 0, binding = kBindAirOut, rgba16f) uniform writeonly image2D out_table;
layout(push_constant) uniform Push { AirData air; };
#define AIR air
#include "air.glsl"

AirRay ray_of(float height, float cosine) { return AirRay(height, cosine, max(1.0 - cosine * cosine, 0.0)); }

vec3 transmittance(uvec2 at) {
    float span = sqrt(AIR.shell.y * (2.0 * AIR.shell.x + AIR.shell.y));
    float rho = span * from_texel(at.y, kTransmittanceHeights);
    float h = rho * rho / (sqrt(AIR.shell.x * AIR.shell.x + rho * rho) + AIR.shell.x);
    float least = AIR.shell.y - h, greatest = rho + span;
    float d = least + (greatest - least) * from_texel(at.x, kTransmittanceCosines);
    float r = radius_of(h);
    float cosine = d <= 0.0 ? 1.0 : clamp((span * span - rho * rho - d * d) / (2.0 * r * d), -1.0, 1.0);
    const int steps = 500;
    vec3 depth = vec3(0.0);
    AirRay ray = ray_of(h, cosine);
    for (int i = 0; i < steps; ++i) depth += medium_at(height_after(ray, d * (float(i) + 0.5) / float(steps))).extinction;
    return exp(-depth * d / float(steps));
}

// Directions spread evenly over the sphere: a Fibonacci lattice.
vec3 spread(int i, int count) {
    float z = 1.0 - (2.0 * float(i) + 1.0) / float(count), a = float(i) * 2.399963229728653;
    return vec3(sqrt(max(1.0 - z * z, 0.0)) * vec2(cos(a), sin(a)), z);
}

// Hillaire's equations 5 to 9.
vec3 multiple(uvec2 at) {
    float cosine = 2.0 * from_texel(at.x, kMultipleCosines) - 1.0;
    float h = AIR.shell.y * square(from_texel(at.y, kMultipleHeights));
    vec3 sun = vec3(sqrt(max(1.0 - cosine * cosine, 0.0)), 0.0, cosine);
    const int directions = 64, steps = 20;
    vec3 second = vec3(0.0), again = vec3(0.0);
    for (int k = 0; k < directions; ++k) {
        vec3 way = spread(k, directions);
        AirRay ray = AirRay(h, way.z, dot(way.xy, way.xy));
        vec2 ground = crossings(ray, 0.0), part = within_air(ray, 1e30);
        bool lands = way.z < 0.0 && ground.x <= ground.y && ground.y > 0.0;
        float end = lands ? max(ground.x, 0.0) : part.y, step = end / float(steps);
        vec3 through = vec3(1.0);
        for (int i = 0; i < steps; ++i) {
            float t = (float(i) + 0.5) * step, height = height_after(ray, t);
            Medium m = medium_at(height);
            float c = clamp((radius_of(h) * cosine + t * dot(way, sun)) / radius_of(height), -1.0, 1.0);
            vec3 passed = exp(-m.extinction * step), share = through * (1.0 - passed) / max(m.extinction, vec3(1e-12));
            second += share * (m.rayleigh + m.mie) * sunlight(height, c) / (4.0 * kAirPi);
            again += share * (m.rayleigh + m.mie);
            through *= passed;
        }
        if (lands) {
            float c = clamp((radius_of(h) * cosine + end * dot(way, sun)) / AIR.shell.x, -1.0, 1.0);
            second += through * sunlight(0.0, c) * max(c, 0.0) * AIR.ground / kAirPi;
        }
    }
    return second / float(directions) / max(1.0 - again / float(directions), vec3(0.05));
}

// On a level surface, from the whole sky without the sun itself.
vec3 irradiance(uvec2 at) {
    float cosine = 2.0 * from_texel(at.x, kSkyLightCosines) - 1.0;
    float h = AIR.shell.y * square(from_texel(at.y, kSkyLightHeights));
    vec3 sun = vec3(sqrt(max(1.0 - cosine * cosine, 0.0)), 0.0, cosine), sum = vec3(0.0);
    const int directions = 256;
    for (int k = 0; k < directions / 2; ++k) {
        vec3 way = spread(k, directions);  // the upper half
        AirRay ray = AirRay(h, way.z, dot(way.xy, way.xy));
        sum += march(ray, 0.0, within_air(ray, 1e30).y, cosine, dot(way, sun), 24).radiance * way.z;
    }
    return sum * (4.0 * kAirPi / float(directions));
}

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    ivec2 size = imageSize(out_table);
    if (at.x >= uint(size.x) || at.y >= uint(size.y)) return;
    vec3 value = kTable == kBindTransmittance ? transmittance(at) : kTable == kBindMultiple ? multiple(at) : irradiance(at);
    imageStore(out_table, ivec2(at), vec4(value, 1.0));
}
