// Colour of the surface: hypsometric and latitude table, relief shading in linear light; sky and sea where they are asked
// for. What is off is compiled away.

layout(constant_id = 0) const bool kSky = false;
layout(constant_id = 1) const bool kWater = false;
layout(constant_id = 2) const bool kDrape = false;
layout(constant_id = 3) const bool kShadows = false;

layout(set = 0, binding = kBindTable) uniform sampler2DArray colour_table;
layout(set = 0, binding = kBindSkyLight) uniform sampler2D sky_light_table;

#define AIR frame.air
#include "air.glsl"

const float kPi = 3.14159265358979;

// Centre of the first texel at 0, of the last at 1, so that the table's ends are its stated heights.
float texel(float t, uint count) { return (clamp(t, 0.0, 1.0) * float(count - 1u) + 0.5) / float(count); }

float latitude_texel(vec3 up) { return texel(atan(up.z, length(up.xy)) / kPi + 0.5, kTableLatitudes); }

vec3 sea_albedo(float height, vec3 up) {
    float sea_floor = frame.table.x, level = frame.table.y;
    float x = texel((height - sea_floor) / (level - sea_floor), kTableHeights);
    return texture(colour_table, vec3(x, latitude_texel(up), 0.0)).rgb;
}

vec3 land_albedo(float height, vec3 up) {
    float level = frame.table.y, top = frame.table.z;
    float x = texel((height - level) / (top - level), kTableHeights);
    return texture(colour_table, vec3(x, latitude_texel(up), 1.0)).rgb;
}

// The coast is a line one pixel wide; at the level itself there is water.
float land_share(float height) { return clamp((height - frame.table.y) / max(fwidth(height), 0.01), 0.0, 1.0); }

// The relief's slope against the ellipsoid, multiplied by the exaggeration.
vec3 exaggerated(vec3 normal, vec3 up, float factor) {
    float along_up = max(dot(normal, up), 1e-3);
    return normalize(up * along_up + (normal - up * dot(normal, up)) * factor);
}

// The sun's share above the horizon of the body itself.
float risen(vec3 up) { return smoothstep(-0.02, 0.04, dot(up, frame.light.xyz)); }

// A ray from the eye, in the space where the body is a sphere (air.glsl).
struct Sight {
    AirRay ray;
    vec3 way;
    float end, sun_cosine, angle;  // of the sun with the vertical at the eye, and with the ray
};

Sight sight_along(vec3 way, float end) {
    vec3 stretched = way * vec3(1.0, 1.0, AIR.shell.z);
    float factor = length(stretched);
    vec3 d = stretched / factor, up = frame.eye_up.xyz;
    float cosine = dot(up, d);
    vec3 level = d - up * cosine;
    return Sight(AirRay(frame.eye_up.w, cosine, dot(level, level)), d, end * factor, dot(up, frame.sun.xyz),
                 dot(d, frame.sun.xyz));
}

Sight sight_to(Sight sight, float end) {
    sight.end = end;
    return sight;
}

vec3 vertical_at_end(Sight sight) {
    return normalize(frame.eye_up.xyz * radius_of(sight.ray.height) + sight.way * sight.end);
}

// Light on its way to the eye loses what the air takes and gains what it scatters.
vec3 through_air(Sight sight, vec3 colour) {
    if (!kSky) return colour;
    vec2 part = within_air(sight.ray, sight.end);
    if (part.x >= part.y) return colour;
    AirLight air = march(sight.ray, part.x, part.y, sight.sun_cosine, sight.angle, int(kAirSteps));
    return colour * air.transmittance + air.radiance * kPi;
}

vec3 sky_light(float height, float cosine) {
    return texture(sky_light_table, sun_place(height, cosine, uvec2(kSkyLightCosines, kSkyLightHeights))).rgb;
}

// Lambert's law for a distant light, hidden by the body itself beyond the terminator or dimmed by its air; the sky; ambient
// light. seen: the sun's share that relief does not hide.
vec3 lighting(vec3 normal, vec3 up, float height, float sun_cosine, float seen) {
    float facing = max(dot(normal, frame.light.xyz), 0.0);
    if (kShadows) facing *= seen;
    vec3 light = vec3(risen(up) * facing);
    if (kSky)
        light = sunlight(height, sun_cosine) * facing + sky_light(height, sun_cosine) * (0.5 + 0.5 * dot(normal, up));
    return mix(light, vec3(1.0), frame.light.w);
}

// Whether the ray dips into the sea, and after which distance.
float sea_distance(Sight sight) { return crossings(sight.ray, frame.table.y).x; }
bool meets_sea(Sight sight) {
    vec2 t = crossings(sight.ray, frame.table.y);
    return sight.ray.height > frame.table.y && t.x <= t.y && t.x > 0.0;
}

float smith(float cosine, float slope) {
    float a = cosine / (slope * sqrt(max(1.0 - cosine * cosine, 1e-6)));
    return a < 1.6 ? (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a) : 0.0;
}

// The sea where a ray that meets it ends, its body of a colour. Glint: slopes of waves after Cox and Munk 1954,
// masked after Smith (in Walter et al. 2007); the sky's mean light is reflected by the mean Fresnel factor of such waves
// (Bruneton, Neyret and Holzschuch 2010, eq. 18 and its fit).
vec3 water_colour(Sight sight, vec3 body) {
    vec3 up = vertical_at_end(sight), sun = frame.sun.xyz;
    float seen = clamp(-dot(up, sight.way), 0.02, 1.0), cosine = dot(up, sun), slope = sqrt(frame.eye.w);
    vec3 north_up = normalize(up * vec3(1.0, 1.0, AIR.shell.z));  // the geodetic vertical
    vec3 sunshine = kSky ? sunlight(frame.table.y, cosine) : vec3(risen(north_up));
    float mirror = 0.02 + 0.98 * pow(1.0 - seen, 5.0 * exp(-2.69 * slope)) / (1.0 + 22.7 * pow(slope, 1.5));
    vec3 colour = body * lighting(north_up, north_up, frame.table.y, cosine, 1.0) * (1.0 - mirror);
    if (kSky) colour += mirror * sky_light(frame.table.y, cosine);
    if (cosine > 0.0) {
        vec3 facet = normalize(sun - sight.way);
        float upright = max(dot(facet, up), 1e-3), tangent2 = 1.0 / (upright * upright) - 1.0;
        float slopes = exp(-tangent2 / frame.eye.w) / (kPi * frame.eye.w);
        float fresnel = 0.02 + 0.98 * pow(1.0 - clamp(dot(facet, sun), 0.0, 1.0), 5.0);
        float masked = 1.0 / (1.0 + smith(seen, slope) + smith(max(cosine, 1e-3), slope));
        colour += sunshine * kPi * fresnel * slopes * masked / (4.0 * seen * square(square(upright)));
    }
    return colour;
}

// tint: the draped colour. seen: the sun's share; water lies in the sun.
vec3 surface_colour(vec3 normal, vec3 up, float height, vec3 relative, vec3 tint, float seen) {
    vec3 u = normalize(up);
    vec3 n = exaggerated(normalize(normal), u, frame.table.w);
    float land = land_share(height);
    vec3 sea_body = kDrape ? tint : sea_albedo(height, u), ground = kDrape ? tint : land_albedo(height, u);
    if (!kSky && !kWater)
        return mix(sea_body, ground, land) * lighting(n, u, height, 0.0, seen) * frame.body.w;
    float distance = length(relative);
    Sight sight = sight_along(relative / distance, distance);
    float cosine = dot(vertical_at_end(sight), frame.sun.xyz);
    vec3 colour = ground;
    if (!kWater) colour = mix(sea_body, colour, land);
    colour *= lighting(n, u, height, cosine, seen);
    if (kWater && land < 1.0 && meets_sea(sight)) {
        Sight sea = sight_to(sight, min(sea_distance(sight), sight.end));
        if (land < 0.5) sight = sea;
        colour = mix(water_colour(sea, sea_body), colour, land);
    }
    return through_air(sight, colour) * frame.body.w;
}
