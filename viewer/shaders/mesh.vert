#version 330 compatibility
out vec3 eye_position;
out vec3 eye_normal;
out vec3 body_position;
out vec4 color;

uniform vec4 clip_plane;  // to the eye; what it cuts away is negative

void main() {
  vec4 eye = gl_ModelViewMatrix * gl_Vertex;
  eye_position = eye.xyz;
  eye_normal = gl_NormalMatrix * gl_Normal;
  body_position = gl_Vertex.xyz;
  color = gl_Color;
  gl_ClipDistance[0] = dot(clip_plane, eye);
  gl_Position = gl_ProjectionMatrix * eye;
}
