// Colour of the surface: hypsometric and latitude table, relief shading in linear light.

layout(set = 0, binding = kBindTable) uniform sampler2DArray colour_table;

const float kPi = 3.14159265358979;

// Centre of the first texel at 0, of the last at 1, so that the table's ends are its stated heights.
float texel(float t, uint count) { return (clamp(t, 0.0, 1.0) * float(count - 1u) + 0.5) / float(count); }

vec3 albedo(float height, vec3 up) {
    float latitude = atan(up.z, length(up.xy)) / kPi + 0.5;
    float v = texel(latitude, kTableLatitudes);
    float sea_floor = frame.table.x, level = frame.table.y, top = frame.table.z;
    vec3 sea = texture(colour_table, vec3(texel((height - sea_floor) / (level - sea_floor), kTableHeights), v, 0.0)).rgb;
    vec3 land = texture(colour_table, vec3(texel((height - level) / (top - level), kTableHeights), v, 1.0)).rgb;
    // The coast is a line one pixel wide; at the level itself there is water.
    float shore = clamp((height - level) / max(fwidth(height), 0.01), 0.0, 1.0);
    return mix(sea, land, shore);
}

// The relief's slope against the ellipsoid, multiplied by the exaggeration.
vec3 exaggerated(vec3 normal, vec3 up, float factor) {
    float along_up = max(dot(normal, up), 1e-3);
    return normalize(up * along_up + (normal - up * dot(normal, up)) * factor);
}

// Lambert's law for a distant light, hidden by the body itself beyond the terminator, and ambient light.
float irradiance(vec3 normal, vec3 up) {
    float lit = smoothstep(-0.02, 0.04, dot(up, frame.light.xyz));
    return mix(lit * max(dot(normal, frame.light.xyz), 0.0), 1.0, frame.light.w);
}

vec3 surface_colour(vec3 normal, vec3 up, float height) {
    vec3 u = normalize(up);
    vec3 n = exaggerated(normalize(normal), u, frame.table.w);
    return albedo(height, u) * irradiance(n, u) * frame.body.w;
}
