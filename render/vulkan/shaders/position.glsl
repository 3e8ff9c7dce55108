// From exact integers to clip space. Whatever draws or probes a vertex goes through these functions, all `precise`, so
// that a vertex shared by patches, which is the same integer triple in each, becomes the same four floats.

layout(std430, set = 0, binding = kBindFrame) readonly buffer Frame { FrameData frame; };
layout(std430, set = 0, binding = kBindVertices) readonly buffer Vertices { VertexData vertices[]; };
layout(std430, set = 0, binding = kBindPatches) readonly buffer Patches { PatchData patches[]; };

// Length units to metres. Magnitude first, then sign, so that the precision is relative to the value: 2^-23 at most. Exact
// up to 2^24 units; metres_per_unit is a power of two.
float metres(int64_t units) {
    uint64_t magnitude = uint64_t(units < 0l ? -units : units);
    precise float high = float(uint(magnitude >> 32)) * 4294967296.0;
    precise float value = (high + float(uint(magnitude & 0xfffffffful))) * frame.metres_per_unit;
    return units < 0l ? -value : value;
}

// The vertex relative to the eye, body axes, metres. The integer sum is exact modulo 2^64.
vec3 relative_to_eye(PatchData patch_data, VertexData v) {
    return vec3(metres(patch_data.x - frame.eye_x + v.x), metres(patch_data.y - frame.eye_y + v.y),
                metres(patch_data.z - frame.eye_z + v.z));
}

float along(vec4 axis, vec3 p) {
    precise float sum = axis.x * p.x + axis.y * p.y + axis.z * p.z;
    return sum;
}

// Reversed depth, near / z, without a far plane; z along forward is also w.
vec4 clip_position(vec3 relative) {
    precise float x = along(frame.right, relative) * frame.right.w;
    precise float y = -along(frame.up, relative) * frame.up.w;
    return vec4(x, y, frame.near_plane, along(frame.forward, relative));
}
