// The atmosphere: a spherical shell around the body stretched along its axis to a sphere of its equatorial radius. After
// E. Bruneton and F. Neyret, Precomputed Atmospheric Scattering, 2008 (transmittance, its parametrisation), and
// S. Hillaire, A Scalable and Production Ready Sky and Atmosphere Rendering Technique, 2020 (higher orders of scattering as
// an isotropic source). Heights and distances in metres. Radiance where the sun's irradiance above the air is 1.
//
// Whoever includes this defines AIR, an AirData.

layout(set = 0, binding = kBindTransmittance) uniform sampler2D transmittance_table;
layout(set = 0, binding = kBindMultiple) uniform sampler2D multiple_table;

const float kAirPi = 3.14159265358979;

float square(float x) { return x * x; }

// A place, and a direction by the cosine (and the sine's square, which keeps digits where the cosine has none) of its angle
// with the vertical.
struct AirRay {
    float height, cosine, sine2;
};

float radius_of(float height) { return AIR.shell.x + height; }

// Above the ground after a distance.
float height_after(AirRay ray, float t) {
    float c = ray.height * (2.0 * AIR.shell.x + ray.height) + t * (2.0 * radius_of(ray.height) * ray.cosine + t);
    return c / (sqrt(max(AIR.shell.x * AIR.shell.x + c, 0.0)) + AIR.shell.x);
}

// Distances to the sphere of that height: x <= y, or x > y where it is missed.
vec2 crossings(AirRay ray, float height) {
    float r = radius_of(ray.height), target = radius_of(height);
    float nearest = sqrt(ray.sine2) * r;
    float half2 = (target - nearest) * (target + nearest);
    if (half2 < 0.0) return vec2(1.0, 0.0);
    float b = r * ray.cosine, root = sqrt(half2);
    float product = (ray.height - height) * (r + target);
    // The sum of like signs first; the other by the product of both.
    float q = b > 0.0 ? -b - root : -b + root;
    float p = q == 0.0 ? 0.0 : product / q;
    return vec2(min(p, q), max(p, q));
}

struct Medium {
    vec3 rayleigh, mie, extinction;
};

Medium medium_at(float height) {
    float h = max(height, 0.0);
    Medium m;
    m.rayleigh = AIR.rayleigh.xyz * exp(-h * AIR.rayleigh.w);
    float dust = exp(-h * AIR.mie.w);
    m.mie = AIR.mie.xyz * dust;
    m.extinction = m.rayleigh + AIR.mie_extinction.xyz * dust +
                   AIR.absorber.xyz * max(0.0, 1.0 - abs(h - AIR.absorber.w) / AIR.shell.w);
    return m;
}

float table_texel(float x, uint size) { return (clamp(x, 0.0, 1.0) * float(size - 1u) + 0.5) / float(size); }
float from_texel(uint i, uint size) { return float(i) / float(size - 1u); }

// Transmittance to the top of the air, the ground in the way or not.
vec3 transmittance_to_top(float height, float cosine) {
    float h = clamp(height, 0.0, AIR.shell.y);
    float r = radius_of(h), top = radius_of(AIR.shell.y), ground = AIR.shell.x;
    float rho = sqrt(h * (2.0 * ground + h)), span = sqrt(AIR.shell.y * (2.0 * ground + AIR.shell.y));
    float b = r * cosine;
    float d = -b + sqrt(max(b * b + (top - r) * (top + r), 0.0));
    float least = AIR.shell.y - h, greatest = rho + span;
    return texture(transmittance_table, vec2(table_texel((d - least) / (greatest - least), kTransmittanceCosines),
                                             table_texel(rho / span, kTransmittanceHeights)))
        .rgb;
}

// Of sunlight at a height; the sun's disc sinks below the ground's horizon.
vec3 sunlight(float height, float cosine) {
    float h = max(height, 0.0);
    float horizon = -sqrt(h * (2.0 * AIR.shell.x + h)) / radius_of(h);
    float risen = smoothstep(-AIR.shell_sun, AIR.shell_sun, cosine - horizon);
    return risen == 0.0 ? vec3(0.0) : risen * transmittance_to_top(h, max(cosine, horizon));
}

vec2 sun_place(float height, float cosine, uvec2 size) {
    return vec2(table_texel(0.5 + 0.5 * cosine, size.x), table_texel(sqrt(clamp(height / AIR.shell.y, 0.0, 1.0)), size.y));
}

vec3 multiple_at(float height, float cosine) {
    return texture(multiple_table, sun_place(height, cosine, uvec2(kMultipleCosines, kMultipleHeights))).rgb;
}

float rayleigh_phase(float c) { return 3.0 / (16.0 * kAirPi) * (1.0 + c * c); }
// Cornette and Shanks 1992.
float mie_phase(float c) {
    float g = AIR.mie_extinction.w, g2 = g * g;
    return 3.0 / (8.0 * kAirPi) * (1.0 - g2) * (1.0 + c * c) / ((2.0 + g2) * pow(max(1.0 + g2 - 2.0 * g * c, 1e-4), 1.5));
}

struct AirLight {
    vec3 radiance, transmittance;
};

// Along a ray from `begin` to `end`, the sun at a cosine with the vertical of the ray's place and with the ray. Steps are
// short where the ray is low. scale: of the phase functions' light, of the isotropic light.
AirLight march(AirRay ray, float begin, float end, float sun_cosine, float angle, int steps) {
    AirLight light = AirLight(vec3(0.0), vec3(1.0));
    float r = radius_of(ray.height), lowest = clamp(-r * ray.cosine, begin, end);
    float split = lowest <= begin ? 0.0 : lowest >= end ? 1.0 : 0.5;
    float phase_r = rayleigh_phase(angle), phase_m = mie_phase(angle), last = begin;
    for (int i = 1; i <= steps; ++i) {
        float x = float(i) / float(steps);
        float next = x <= split ? lowest - (lowest - begin) * square(1.0 - x / max(split, 1e-3))
                                : lowest + (end - lowest) * square((x - split) / max(1.0 - split, 1e-3));
        float t = 0.5 * (last + next), h = height_after(ray, t);
        Medium m = medium_at(h);
        float cosine = clamp((r * sun_cosine + t * angle) / radius_of(h), -1.0, 1.0);
        vec3 source = sunlight(h, cosine) * (m.rayleigh * phase_r + m.mie * phase_m);
        if (AIR.multiple > 0.0) source += multiple_at(h, cosine) * (m.rayleigh + m.mie);
        vec3 through = exp(-m.extinction * (next - last));
        light.radiance += light.transmittance * source * (1.0 - through) / max(m.extinction, vec3(1e-12));
        light.transmittance *= through;
        last = next;
    }
    return light;
}

// The part of a ray, until `end`, that lies in the air: x >= y where there is none.
vec2 within_air(AirRay ray, float end) {
    vec2 shell = crossings(ray, AIR.shell.y);
    if (shell.x > shell.y) return vec2(1.0, 0.0);
    return vec2(max(shell.x, 0.0), min(shell.y, end));
}
