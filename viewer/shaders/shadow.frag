#version 330 compatibility
// Only the depth counts; particles are discs.
uniform bool sprites;

void main() {
  vec2 q = 2.0 * gl_PointCoord - 1.0;
  if (sprites && dot(q, q) > 1.0) discard;
}
