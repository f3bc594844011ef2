#version 330 compatibility
out vec2 world;
out vec3 eye_position;

void main() {
  world = gl_Vertex.xy;
  eye_position = (gl_ModelViewMatrix * gl_Vertex).xyz;
  gl_Position = gl_ModelViewProjectionMatrix * gl_Vertex;
}
