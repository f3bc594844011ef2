#version 330 compatibility
// How much of the surroundings of a texel a medium's particles cover, 0 .. 1: every covered texel is spread out by a
// normal distribution as wide as its distance asks for, along one axis after the other. Where it is one half, the
// outline of beads has become a smooth line. The same for the edge of a layer, where the medium stands before a farther
// part of itself.
// Out of the first axis come the share that is covered, the shares of layers nearer and farther than this texel's, and
// the texel's distance, negative where only its surroundings have one. Out of the second one come the share that is
// covered, how much of it is of the layer that the texel is of (at least one half), the distance times the first, and how
// much is of the nearer of two layers (1 where there is one layer).
uniform sampler2D covered;
uniform ivec2 along;              // one texel
uniform bool by_distance;         // covered holds distances, and has twice as many texels along each side
uniform float target_height;      // [texels]
uniform float spread;             // standard deviation [m]
uniform float range;              // of distances that belong to one layer [m]
uniform int outline_taps;         // to each side
uniform float outline_stride;     // [texels] between them

const float kFarthest = 6e4;  // [m] that a half float holds

vec4 at(float offset) {
  ivec2 place = ivec2(gl_FragCoord.xy) + along * int(round(offset));
  if (!by_distance) return texelFetch(covered, clamp(place, ivec2(0), textureSize(covered, 0) - 1), 0);
  place = clamp(2 * place, ivec2(0), textureSize(covered, 0) - 1);
  float a = texelFetch(covered, place, 0).r;
  float b = texelFetch(covered, min(place + 1, textureSize(covered, 0) - 1), 0).r;
  float share = 0.5 * (float(a > 0.0) + float(b > 0.0));
  return vec4(share, 0.0, 0.0, min(a > 0.0 && b > 0.0 ? min(a, b) : max(a, b), kFarthest));
}

float least, most, texels;
vec4 sum = vec4(0.0);  // as the first axis has it, with the distance times the share

// layer: how much the value is of a nearer layer (down to -1) or of a farther one (up to 1).
void add(vec4 value, float offset, float layer) {
  float width = clamp(texels / abs(value.w), least, max(least, most));
  float t = offset / width;
  vec2 other = layer < 0.0 ? vec2(value.x - value.z, 0.0) : vec2(0.0, value.x - value.y);
  vec2 nearer_farther = mix(value.yz, other, abs(layer));
  sum += vec4(value.x, nearer_farther, value.x * abs(value.w)) *
         (exp(-0.5 * t * t) * outline_stride / (2.5066 * width));
}

void main() {
  least = max(0.7, 0.8 * outline_stride);
  most = float(outline_taps) * outline_stride / 2.2;
  texels = 0.5 * target_height * gl_ProjectionMatrix[1][1] * spread;
  vec4 middle = at(0.0);
  if (middle.x > 0.0) add(middle, 0.0, 0.0);
  for (int side = -1; side <= 1; side += 2) {
    // on the way from the middle each step of distance that no surface makes leads to another layer; the end of such an
    // edge, where steps get smaller, fades
    float last = middle.w;
    float layer = 0.0;
    for (int i = 1; i <= outline_taps; ++i) {
      float offset = round(float(side * i) * outline_stride);
      vec4 value = at(offset);
      if (value.x <= 0.0) continue;
      if (middle.w > 0.0 && value.w > 0.0) {
        float step = value.w - last;
        layer = clamp(layer + sign(step) * smoothstep(range, 2.0 * range, abs(step)), -1.0, 1.0);
        last = value.w;
      }
      add(value, offset, layer);
    }
  }
  if (by_distance) {
    gl_FragColor = vec4(sum.xyz, middle.w > 0.0 ? middle.w : -sum.w / max(sum.x, 1e-6));
    return;
  }
  float nearer = sum.x > 0.0 ? (sum.y > sum.z ? sum.y / sum.x : 1.0 - sum.z / sum.x) : 1.0;
  gl_FragColor = vec4(sum.x, 0.5 + abs(nearer - 0.5), sum.w, nearer);
}
