#version 330 compatibility
// A narrow-range filter along one axis (Truong and Yuksel, 2018): means over neighbours at about the same distance, so
// that beads become a surface and edges stay. What the outline encloses between beads is filled, too.
uniform sampler2D surface;
uniform sampler2D outline;    // as medium_outline.frag has it
uniform bool fills;           // what the outline encloses
uniform ivec2 along;          // one texel
uniform float target_height;  // [texels]
uniform float reach;          // of the filter [m]
uniform float range;          // of distances that belong to one surface [m]
uniform float clamp_range;    // neighbours farther behind than this count as no farther [m]
uniform int most_taps;        // to each side

const int kFarthest = 8;  // [texels] that a gap is wide to one side at most

float texels(float size, float depth) { return 0.5 * target_height * gl_ProjectionMatrix[1][1] * size / depth; }

vec2 at(int i) { return texelFetch(surface, ivec2(gl_FragCoord.xy) + along * i, 0).rg; }

// Somewhat more than the outline encloses, so that slopes at it have neighbours; with the scalar of what is next to it.
vec2 filled() {
  vec4 o = texture2D(outline, gl_FragCoord.xy / vec2(textureSize(surface, 0)));
  if (o.x <= 0.3) return vec2(0.0);
  for (int r = 1; r <= kFarthest; ++r)
    for (int k = 0; k < 9; ++k) {
      vec2 a = texelFetch(surface, ivec2(gl_FragCoord.xy) + r * (ivec2(k % 3, k / 3) - 1), 0).rg;
      if (a.x > 0.0) return vec2(o.z / o.x, a.y);
    }
  return vec2(o.z / o.x, 0.0);
}

// What a neighbour counts as: no farther behind than this, and with no scalar of another layer.
vec2 bounded(vec2 a, vec2 middle) {
  return vec2(min(a.x, middle.x + clamp_range), a.x > middle.x + range ? middle.y : a.y);
}

void main() {
  vec2 middle = at(0);
  if (middle.x <= 0.0 && fills) middle = filled();
  if (middle.x <= 0.0) {
    gl_FragColor = vec4(0.0, 0.0, 0.0, 1.0);
    return;
  }
  float size = max(texels(reach, middle.x), 1.0);
  int taps = min(int(size), most_taps);
  float stride = min(size, 3.0 * float(taps)) / float(taps);
  float nearest = middle.x - range;
  vec2 sum = middle;
  float weights = 1.0;
  for (int i = 1; i <= taps; ++i) {
    int offset = int(float(i) * stride);
    vec2 a = at(offset), b = at(-offset);
    // with one of a pair its mirror image goes, or the surface would lean to the other side
    if (min(a.x, b.x) < nearest || min(a.x, b.x) <= 0.0) continue;
    nearest = min(nearest, min(a.x, b.x) - range);
    a = bounded(a, middle);
    b = bounded(b, middle);
    float t = 2.0 * float(i) / float(taps);
    float w = exp(-t * t);
    sum += w * (a + b);
    weights += 2.0 * w;
  }
  gl_FragColor = vec4(sum / weights, 0.0, 1.0);
}
