#version 330 compatibility
// A particle: gl_Vertex.xyz is its centre in the world, gl_Vertex.w the scalar (below -1e38: it has none), gl_Color its
// body's colour.
uniform float picture_height;  // [pixels]
uniform sampler1D color_map;
uniform vec2 value_range;  // scalar at the map's two ends
uniform bool by_scalar;
uniform float radius;

flat out vec3 center;
flat out vec3 color;  // linear
flat out float pixel_radius;

vec3 to_linear(vec3 shown);
float front_depth(float front, vec4 at);

void main() {
  vec4 eye = gl_ModelViewMatrix * vec4(gl_Vertex.xyz, 1.0);
  center = eye.xyz;
  float t = clamp((gl_Vertex.w - value_range.x) / (value_range.y - value_range.x), 0.0, 1.0);
  vec3 shown = by_scalar && gl_Vertex.w > -1e38 ? textureLod(color_map, (t * 255.0 + 0.5) / 256.0, 0.0).rgb : gl_Color.rgb;
  color = to_linear(shown);
  gl_Position = gl_ProjectionMatrix * eye;
  gl_Position.z = front_depth(eye.z + 1.03 * radius, gl_Position);
  gl_PointSize = max(picture_height * gl_ProjectionMatrix[1][1] * radius / gl_Position.w, 1.0);
  pixel_radius = 0.5 * gl_PointSize;
}
