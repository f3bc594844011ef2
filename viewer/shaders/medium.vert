#version 330 compatibility
// A particle of a medium that is drawn as a surface: gl_Vertex.xyz is its centre in the world, gl_Vertex.w the scalar
// (below -1e38: it has none), gl_Color its body's colour.
uniform float target_height;  // [pixels]
uniform float radius;         // of the sprite [m]
uniform vec2 value_range;

flat out vec3 center;
flat out vec3 tint;
flat out float scalar;

void main() {
  vec4 eye = gl_ModelViewMatrix * vec4(gl_Vertex.xyz, 1.0);
  center = eye.xyz;
  tint = gl_Color.rgb;
  scalar = gl_Vertex.w > -1e38 ? gl_Vertex.w : value_range.x;
  gl_Position = gl_ProjectionMatrix * eye;
  gl_PointSize = max(target_height * gl_ProjectionMatrix[1][1] * radius / gl_Position.w, 1.0);
}
