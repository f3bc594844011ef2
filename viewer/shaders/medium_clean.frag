#version 330 compatibility
// The same filter in both directions at once over a few texels: it takes away the streaks that one axis after the other
// leaves. Then the surface, which goes on into the walls that it touches, ends at them.
uniform sampler2D surface;
uniform float range;        // [m]
uniform float clamp_range;  // [m]
uniform int most_taps;      // to each side
uniform int stride;         // [texels] between them
uniform bool ended_by_walls;
uniform sampler2D walls;  // as wall_depths.frag has them

// Returns the distance at which the surface is seen that was found at this one: through a wall where it stands against
// that wall; 0 where it is not seen, because the ray stays within the wall.
float ended(float depth) {
  vec3 wall = texelFetch(walls, ivec2(gl_FragCoord.xy), 0).rgb;
  float into = wall.r, into_hollow = wall.g, out_of = wall.b;
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
  if (ended_by_walls && sum.x > 0.0) sum.x = ended(sum.x);
  gl_FragColor = vec4(sum, 0.0, 1.0);
}
