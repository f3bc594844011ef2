#version 330 compatibility
// The same filter in both directions at once over a few texels: it takes away the streaks that one axis after the other
// leaves. The last bit of a distance says whether what is found there stands against the walls of a hollow.
uniform sampler2D surface;
uniform sampler2D unsmoothed;  // as medium_depth.frag has it
uniform float range;        // [m]
uniform float clamp_range;  // [m]
uniform int most_taps;      // to each side
uniform int stride;         // [texels] between them
uniform bool ended_by_walls;

// Returns whether what is found here does; where a gap was closed, what is beside it.
bool in_hollow() {
  for (int reach = 0; reach <= 4; ++reach)
    for (int k = 0; k < 4; ++k) {
      ivec2 beside = reach * ivec2((k & 1) * (k - 2), (1 - (k & 1)) * (k - 1));
      float found = texelFetch(unsmoothed, ivec2(gl_FragCoord.xy) + beside, 0).r;
      if (found > 0.0) return (floatBitsToInt(found) & 1) == 1;
    }
  return false;
}

vec2 at(ivec2 offset) { return texelFetch(surface, ivec2(gl_FragCoord.xy) + offset, 0).rg; }

// What a neighbour counts as: no farther behind than this, and with no scalar of another layer.
vec2 bounded(vec2 a, vec2 middle) {
  return vec2(min(a.x, middle.x + clamp_range), a.x > middle.x + range ? middle.y : a.y);
}

void main() {
  vec2 middle = at(ivec2(0));
  vec2 sum = middle;
  float weights = 1.0;
  if (middle.x > 0.0) {
    for (int y = -most_taps; y <= most_taps; ++y) {
      for (int x = 0; x <= most_taps; ++x) {
        if (x == 0 && y <= 0) continue;
        vec2 a = at(stride * ivec2(x, y)), b = at(-stride * ivec2(x, y));
        if (min(a.x, b.x) < middle.x - range || min(a.x, b.x) <= 0.0) continue;
        a = bounded(a, middle);
        b = bounded(b, middle);
        float w = exp(-float(x * x + y * y) / float(most_taps * most_taps));
        sum += w * (a + b);
        weights += 2.0 * w;
      }
    }
  }
  sum /= weights;
  int stands_in_hollow = ended_by_walls && sum.x > 0.0 && in_hollow() ? 1 : 0;
  sum.x = intBitsToFloat((floatBitsToInt(sum.x) & ~1) | stands_in_hollow);
  gl_FragColor = vec4(sum, 0.0, 1.0);
}
