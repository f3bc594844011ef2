#version 330 compatibility
// The white around a fast drop: most in its middle, nothing at its rim.
flat in vec4 color;

void main() {
  vec2 q = 2.0 * gl_PointCoord - 1.0;
  float share = max(1.0 - dot(q, q), 0.0);
  gl_FragColor = vec4(color.rgb, color.a * share * share);
}
