#version 330 compatibility
out vec2 at;

void main() {
  at = gl_Vertex.xy;
  gl_Position = vec4(gl_Vertex.xy, 0.0, 1.0);
}
