#version 330 compatibility
// The white around a fast drop, which drop.vert tells of: too fine to be seen drop by drop.
uniform float picture_height;  // [pixels]
uniform float radius;          // [m]
uniform sampler2D looks;

flat out vec4 color;  // as a screen shows it

vec3 scattered(vec3 color, float softness, vec3 normal, vec2 shares);
vec2 light_shares(vec3 eye_point, vec3 normal);
vec3 display(vec3 light);
vec3 key_light();
float front_depth(float front, vec4 at);

const float kMost = 0.35;  // of what is behind it is hidden

void main() {
  int row = int(gl_Color.a * 255.0 + 0.5);
  // what is alone is a drop that is white itself
  float white = texelFetch(looks, ivec2(2, row), 0).y * fract(gl_MultiTexCoord0.w) * (1.0 - 0.85 * gl_Vertex.w);
  vec4 eye = gl_ModelViewMatrix * vec4(gl_Vertex.xyz, 1.0);
  vec3 normal = normalize(key_light() + vec3(0.0, 0.0, 1.0));
  color = vec4(display(scattered(vec3(0.92, 0.94, 0.95), 0.9, normal, light_shares(eye.xyz, normal))), kMost * white);
  gl_Position = gl_ProjectionMatrix * eye;
  gl_Position.z = front_depth(eye.z + radius, gl_Position);  // before the liquid that it is part of
  gl_PointSize = max(picture_height * gl_ProjectionMatrix[1][1] * radius / gl_Position.w, 1.0);
  if (white <= 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}
