#version 330 compatibility
out vec2 world;

void main() {
  world = gl_Vertex.xy;
  gl_Position = gl_ModelViewProjectionMatrix * gl_Vertex;
}
