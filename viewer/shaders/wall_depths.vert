#version 330 compatibility
out float depth;  // [m] along the view

void main() {
  vec4 eye = gl_ModelViewMatrix * gl_Vertex;
  depth = -eye.z;
  gl_Position = gl_ProjectionMatrix * eye;
}
