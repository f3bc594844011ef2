#version 330 compatibility
// How much of the surroundings of a texel a medium's particles cover, 0 .. 1, and their mean distance and scalar, each
// times that: every covered texel is spread out by a normal distribution as wide as its distance asks for, along one
// axis after the other. Where it is one half, the outline of beads has become a smooth line.
uniform sampler2D covered;
uniform ivec2 along;              // one texel
uniform bool by_distance;         // covered holds distance and scalar, and has twice as many texels along each side
uniform float target_height;      // [texels]
uniform float spread;             // standard deviation [m]
uniform int outline_taps;         // to each side
uniform float outline_stride;     // [texels] between them

vec3 of_surface(ivec2 place) {
  vec2 s = texelFetch(covered, min(place, textureSize(covered, 0) - 1), 0).rg;
  return s.x > 0.0 ? vec3(1.0, s) : vec3(0.0);
}

vec3 at(float offset) {
  ivec2 place = ivec2(gl_FragCoord.xy) + along * int(round(offset));
  if (!by_distance) return texelFetch(covered, clamp(place, ivec2(0), textureSize(covered, 0) - 1), 0).rgb;
  place = clamp(2 * place, ivec2(0), textureSize(covered, 0) - 1);
  return 0.5 * (of_surface(place) + of_surface(place + 1));
}

void main() {
  float least = max(0.7, 0.8 * outline_stride), most = float(outline_taps) * outline_stride / 2.2;
  float texels = 0.5 * target_height * gl_ProjectionMatrix[1][1] * spread;
  vec3 sum = vec3(0.0);
  for (int i = -outline_taps; i <= outline_taps; ++i) {
    float offset = float(i) * outline_stride;
    vec3 value = at(offset);
    if (value.x <= 0.0) continue;
    float width = clamp(texels * value.x / value.y, least, max(least, most));
    float t = round(offset) / width;
    sum += value * (exp(-0.5 * t * t) * outline_stride / (2.5066 * width));
  }
  gl_FragColor = vec4(sum, 1.0);
}
