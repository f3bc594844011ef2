#version 330 compatibility
// How much of a clear medium lies along the view [m], summed up over the particles: all that is to be known where it has
// one look.
uniform float radius;  // of a particle's sprite [m]
uniform float lump_over_spacing;
uniform float chord_share;  // makes the volume of a sprite that of a particle

flat in float weight;

void main() {
  vec2 q = 2.0 * gl_PointCoord - 1.0;
  float r2 = dot(q, q);
  if (r2 > 1.0) discard;
  gl_FragColor = vec4(2.0 * radius * lump_over_spacing * sqrt(1.0 - r2) * chord_share * weight);
}
