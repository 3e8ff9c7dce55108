// One triangle over the whole picture, infinitely far away.
#version 460

layout(location = 0) out vec2 out_screen;

void main() {
    out_screen = vec2(gl_VertexIndex == 1 ? 3.0 : -1.0, gl_VertexIndex == 2 ? 3.0 : -1.0);
    gl_Position = vec4(out_screen, 0.0, 1.0);
}
