#version 330 compatibility
#extension GL_ARB_conservative_depth : enable
// A sphere drawn on a point sprite, with the sphere's own depth.
uniform float radius;

flat in vec3 center;
flat in vec3 color;  // linear
flat in float pixel_radius;

// The sprite has the depth of the sphere's front, so that hidden ones are known before they are drawn.
#ifdef GL_ARB_conservative_depth
layout(depth_greater) out float gl_FragDepth;
#endif

vec3 shade(vec3 color, float roughness, float metallic, float f0, float softness, vec3 normal, vec3 to_eye, vec2 shares);
vec2 light_shares(vec3 eye_point, vec3 normal);
vec3 display(vec3 light);

void main() {
  vec2 q = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);
  float r2 = dot(q, q);
  if (r2 > 1.0) discard;
  vec3 normal = vec3(q, sqrt(1.0 - r2));
  vec3 p = center + radius * normal;
  float ndc = (gl_ProjectionMatrix[2][2] * p.z + gl_ProjectionMatrix[3][2]) / -p.z;
  gl_FragDepth = clamp(0.5 * ndc + 0.5, 0.0, 1.0);
  // the rim fades where there are several samples a pixel (alpha to coverage)
  float coverage = clamp((1.0 - sqrt(r2)) * pixel_radius + 0.25, 0.0, 1.0);
  vec3 light = shade(color, 0.42, 0.0, 0.04, 0.1, normal, vec3(0.0, 0.0, 1.0), light_shares(p, normal));
  gl_FragColor = vec4(display(light), coverage);
}
