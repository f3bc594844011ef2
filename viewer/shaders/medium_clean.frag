#version 330 compatibility
// The same filter in both directions at once over a few texels: it takes away the streaks that one axis after the other
// leaves. Then the surface, which goes on into the walls that it touches, ends at them.
uniform sampler2D surface;
uniform sampler2D unsmoothed;  // as medium_depth.frag has it
uniform float range;        // [m]
uniform float clamp_range;  // [m]
uniform int most_taps;      // to each side
uniform int stride;         // [texels] between them
uniform bool ended_by_walls;
uniform sampler2D walls;  // as wall_depths.frag has them

// Returns whether what is found here stands against the walls of a hollow; where a gap was closed, what is beside it.
bool in_hollow() {
  for (int reach = 0; reach <= 4; ++reach)
    for (int k = 0; k < 4; ++k) {
      ivec2 beside = reach * ivec2((k & 1) * (k - 2), (1 - (k & 1)) * (k - 1));
      float found = texelFetch(unsmoothed, ivec2(gl_FragCoord.xy) + beside, 0).r;
      if (found > 0.0) return (floatBitsToInt(found) & 1) == 1;
    }
  return false;
}

// Returns the distance at which the surface is seen that was found at this one: through a wall where it stands against
// that wall; 0 where it is not seen, because the ray stays within the wall.
float ended(float depth, bool stands_in_hollow) {
  vec4 wall = texelFetch(walls, ivec2(gl_FragCoord.xy), 0);
  float into = wall.r, into_hollow = wall.g, out_of = wall.b, out_of_hollow = wall.a;
  if (stands_in_hollow) {
    if (min(into_hollow, out_of_hollow) > 1e29 || depth > out_of_hollow) return 0.0;
    return into_hollow < out_of_hollow ? max(depth, into_hollow) : depth;
  }
  if (depth <= into) return depth;
  if (into_hollow < 1e29 && into <= into_hollow) return max(depth, into_hollow);
  return depth < out_of && out_of < 1e29 ? 0.0 : depth;
}

vec2 at(ivec2 offset) { return texelFetch(surface, ivec2(gl_FragCoord.xy) + offset, 0).rg; }

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
        a.x = min(a.x, middle.x + clamp_range);
        b.x = min(b.x, middle.x + clamp_range);
        float w = exp(-float(x * x + y * y) / float(most_taps * most_taps));
        sum += w * (a + b);
        weights += 2.0 * w;
      }
    }
  }
  sum /= weights;
  int stands_in_hollow = 0;
  if (ended_by_walls && sum.x > 0.0) {
    stands_in_hollow = in_hollow() ? 1 : 0;
    sum.x = ended(sum.x, stands_in_hollow == 1);
  }
  // the last bit says so to the shading, too
  sum.x = intBitsToFloat((floatBitsToInt(sum.x) & ~1) | stands_in_hollow);
  gl_FragColor = vec4(sum, 0.0, 1.0);
}
