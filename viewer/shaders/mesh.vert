#version 330 compatibility
out vec3 eye_position;
out vec3 eye_normal;
out vec4 color;

void main() {
  vec4 eye = gl_ModelViewMatrix * gl_Vertex;
  eye_position = eye.xyz;
  eye_normal = gl_NormalMatrix * gl_Normal;
  color = gl_Color;
  gl_Position = gl_ProjectionMatrix * eye;
}
