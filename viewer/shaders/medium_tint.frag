#version 330 compatibility
// Summed up over the particles: how much of a clear medium lies along the view [m] and what it absorbs, or the colour
// of an opaque one near its surface; and what their surfaces are like, each weighing as much as in the first sum.
uniform sampler2D surface;
uniform vec2 surface_per_target;  // texels of the surface a pixel
uniform float radius;  // of a particle's sprite [m]
uniform float lump_over_spacing;
uniform float chord_share;  // makes the volume of a sprite that of a particle
uniform float skin;         // [m] below the surface that gives an opaque medium its colour
uniform bool is_clear;

flat in vec3 center;
flat in float weight;
flat in vec3 tint;
flat in vec4 depth_of_color;
flat in vec4 surface_look;

void main() {
  vec2 q = 2.0 * gl_PointCoord - 1.0;
  float r2 = dot(q, q);
  if (r2 > 1.0) discard;
  float chord = 2.0 * radius * lump_over_spacing * sqrt(1.0 - r2) * chord_share * weight;
  if (is_clear) {
    gl_FragData[0] = vec4(depth_of_color.rgb * chord, chord);
    gl_FragData[1] = vec4(surface_look.x, depth_of_color.a, surface_look.zw) * chord;
    return;
  }
  float front = texelFetch(surface, ivec2(gl_FragCoord.xy * surface_per_target), 0).r;
  // a gap that will be closed has no surface yet
  float near = front > 0.0 ? clamp(1.0 - (-center.z - front) / skin, 0.0, 1.0) : 1.0;
  // a colour of its own keeps black apart from nothing
  gl_FragData[0] = vec4(max(tint, vec3(0.002)), 1.0) * (chord * near);
  gl_FragData[1] = surface_look * (chord * near);
}
