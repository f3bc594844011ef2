#version 330 compatibility
#extension GL_ARB_conservative_depth : enable
// The distance of a medium's particles along the view [m], and their scalar. The spheres are wider than particles, so
// that they close up, and sunk, so that their tops are where those of particles would be. What stands against the walls
// of a hollow has the last bit of its distance set.
uniform float radius;
uniform float sink;  // [m]

flat in vec3 center;
flat in float size;
flat in float scalar;
flat in int in_hollow;

// The sprite has the depth of the sphere's front, so that hidden ones are known before they are drawn.
#ifdef GL_ARB_conservative_depth
layout(depth_greater) out float gl_FragDepth;
#endif

void main() {
  vec2 q = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);
  float r2 = dot(q, q);
  if (r2 > 1.0) discard;
  float z = center.z + size * (radius * sqrt(1.0 - r2) - sink);
  if (z > -1e-4) discard;
  float ndc = (gl_ProjectionMatrix[2][2] * z + gl_ProjectionMatrix[3][2]) / -z;
  gl_FragDepth = clamp(0.5 * ndc + 0.5, 0.0, 1.0);
  gl_FragColor = vec4(intBitsToFloat((floatBitsToInt(-z) & ~1) | in_hollow), scalar, 0.0, 1.0);
}
