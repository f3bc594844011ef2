#version 330 compatibility
// The surface of a medium in the picture: lit where it is opaque; where it is clear, with what lies behind it, refracted
// and absorbed, and what it reflects.
uniform sampler2D surface;
uniform sampler2D tints;
uniform sampler2D surface_looks;  // as medium_tint.frag has them
uniform sampler2D outline;  // as medium_outline.frag has it
uniform bool ended_by_walls;
uniform sampler2D walls;  // as wall_depths.frag has them, a texel a pixel
uniform sampler2D scene_color;
uniform sampler2D scene_depth;
uniform sampler1D color_map;
uniform vec2 target_size;   // of the picture [pixels]
uniform vec2 surface_size;  // [texels]
uniform vec2 tints_size;
uniform vec2 value_range;
uniform float spread;  // as medium_outline.frag has it
uniform float range;  // of distances that belong to one surface [m]
uniform float lift;   // [m] off the surface, where its light is asked for
uniform bool by_scalar;
uniform bool is_clear;
uniform bool one_tint;   // all of it has this look: of a clear medium tints are its thickness alone, else there are none
uniform vec4 own_tint;   // sRGB and the depth that gives it [m]; or what a clear medium absorbs [1/m]
uniform vec4 own_look;

const float kInside = 0.8;       // of the surroundings are covered where the beads of an outline are not seen any more
const float kLeastSlope = 0.2;   // of an outline: half of what a straight one has; between two that meet there is none
const float kAgainstWalls = 0.1; // of what a surface reflects that faces sideways
const float kWandered = 0.1;     // [m] of a clear medium that light which comes back from it has been through at most

vec3 shade(vec3 color, float roughness, float metallic, float f0, float softness, vec3 normal, vec3 to_eye, vec2 shares);
vec3 reflected(vec3 f0, float roughness, vec3 normal, vec3 to_eye, vec2 shares);
vec3 scattered(vec3 color, float softness, vec3 normal, vec2 shares);
vec3 room_light(vec3 normal);
vec2 light_shares(vec3 eye_point, vec3 normal);
vec3 in_world(vec3 direction);
vec3 display(vec3 light);
vec3 light_of(vec3 shown);
vec3 to_linear(vec3 shown);

// The surface between texels, made of those at about the distance of the nearest one, or of the farthest one; x is 0
// where there is none.
vec2 surface_at(vec2 place, bool nearer) {
  ivec2 i = ivec2(floor(place - 0.5));
  vec2 t = place - 0.5 - vec2(i);
  vec2 s[4] = vec2[4](texelFetch(surface, i, 0).rg, texelFetch(surface, i + ivec2(1, 0), 0).rg,
                      texelFetch(surface, i + ivec2(0, 1), 0).rg, texelFetch(surface, i + ivec2(1, 1), 0).rg);
  vec4 w = vec4((1.0 - t.x) * (1.0 - t.y), t.x * (1.0 - t.y), (1.0 - t.x) * t.y, t.x * t.y);
  float side = nearer ? 1.0 : -1.0, first = 1e30;
  for (int k = 0; k < 4; ++k) first = s[k].x > 0.0 && w[k] > 0.01 ? min(first, side * s[k].x) : first;
  vec2 sum = vec2(0.0);
  float weights = 0.0;
  for (int k = 0; k < 4; ++k) {
    if (s[k].x <= 0.0 || side * s[k].x > first + range) continue;
    sum += w[k] * s[k];
    weights += w[k];
  }
  return weights > 0.0 ? sum / weights : vec2(0.0);
}

vec3 eye_point(vec2 place, float depth) {
  vec2 ndc = 2.0 * place / surface_size - 1.0;
  return vec3(ndc * depth / vec2(gl_ProjectionMatrix[0][0], gl_ProjectionMatrix[1][1]), -depth);
}

// How much of the surroundings of a place that is so far from the pixel an outline encloses, that of the medium or that
// of one of its layers.
float enclosed_at(vec2 offset) {
  vec4 o = texture2D(outline, (gl_FragCoord.xy + offset) / target_size);
  return min(o.x, o.y);
}

// The smaller of the differences to both sides, so that an edge does not bend the normal on its near side.
vec3 slope(vec2 place, vec3 p, vec2 offset, bool nearer) {
  float after = surface_at(place + offset, nearer).x, before = surface_at(place - offset, nearer).x;
  vec3 forth = eye_point(place + offset, after) - p, back = p - eye_point(place - offset, before);
  if (after <= 0.0) return before <= 0.0 ? vec3(offset, 0.0) : back;
  return before > 0.0 && abs(back.z) < abs(forth.z) ? back : forth;
}

// The place of the ray where the surface goes on flat from q, but not much farther.
vec3 flat_from(vec3 q, vec3 normal, vec3 ray) {
  float slant = dot(ray, normal);
  float depth = abs(slant) > 1e-4 ? dot(q, normal) / slant : 0.0;
  return ray * clamp(depth, -q.z, -q.z + range);
}

// The distances of walls in a pixel [m], of the kinds that wall_depths.frag tells of; 1e30 where there are none.
vec4 wall_distances(ivec2 pixel) { return 1.0 / max(texelFetch(walls, pixel, 0), 1e-30); }

// How such a distance changes from one pixel to the next, where both are on one face.
float wall_slope(int of, ivec2 offset) {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float here = wall_distances(pixel)[of];
  float forth = wall_distances(pixel + offset)[of] - here, back = here - wall_distances(pixel - offset)[of];
  return abs(back) < abs(forth) ? back : forth;
}

// The normal of the face of walls that is p, seen at this place.
vec3 wall_normal(int of, vec2 place, vec3 p, vec2 texels_per_pixel) {
  float right = wall_slope(of, ivec2(1, 0)), up = wall_slope(of, ivec2(0, 1));
  vec3 along = eye_point(place + vec2(texels_per_pixel.x, 0.0), right - p.z) - p;
  vec3 upward = eye_point(place + vec2(0.0, texels_per_pixel.y), up - p.z) - p;
  return normalize(cross(along, upward));
}

// Ends a surface at the walls that it goes on into: where its place p is in a wall that one looks through, it is seen
// where that wall ends, and takes the wall's normal; within a wall it is not seen. Returns the share of the pixel in
// which it is seen.
float end_at_walls(bool stands_in_hollow, vec2 place, vec2 texels_per_pixel, inout vec3 p, inout vec3 normal) {
  const int kIntoHollow = 1, kOutOfHollow = 3;
  vec4 wall = wall_distances(ivec2(gl_FragCoord.xy));
  float into = wall.r, into_hollow = wall.g, out_of = wall.b, out_of_hollow = wall.a, depth = -p.z;
  float seen = 1.0;
  if (stands_in_hollow) {
    if (min(into_hollow, out_of_hollow) > 1e29) return 0.0;
    if (out_of_hollow < 1e29) {
      // how much farther the wall is than the surface, over how much that changes within a pixel
      float room = out_of_hollow - depth, plane = dot(p, normal);
      vec3 beside = eye_point(place + vec2(texels_per_pixel.x, 0.0), 1.0);
      vec3 above = eye_point(place + vec2(0.0, texels_per_pixel.y), 1.0);
      vec2 of_surface = plane / vec2(dot(beside, normal), dot(above, normal)) - depth;
      vec2 of_wall = vec2(wall_slope(kOutOfHollow, ivec2(1, 0)), wall_slope(kOutOfHollow, ivec2(0, 1)));
      vec2 change = of_wall - of_surface;
      seen = clamp(room / clamp(abs(change.x) + abs(change.y), 1e-5, 0.1 * range) + 0.5, 0.0, 1.0);
    }
    if (into_hollow >= out_of_hollow) return seen;
  } else {
    if (depth <= into) return 1.0;
    if (into_hollow > 1e29 || into > into_hollow) return depth < out_of && out_of < 1e29 ? 0.0 : 1.0;
  }
  if (depth < into_hollow) {
    p = eye_point(place, into_hollow);
    normal = wall_normal(kIntoHollow, place, p, texels_per_pixel);
  }
  return seen;
}

float linear_depth(float window_depth) {
  return gl_ProjectionMatrix[3][2] / (2.0 * window_depth - 1.0 + gl_ProjectionMatrix[2][2]);
}

// Where the picture shows what a ray hits that is bent at the surface and goes on through the medium.
vec2 bent_to(vec3 p, vec3 normal, vec3 to_eye, float index, float thick) {
  vec3 q = p + refract(-to_eye, normal, 1.0 / index) * thick;
  vec2 ndc = q.xy * vec2(gl_ProjectionMatrix[0][0], gl_ProjectionMatrix[1][1]) / max(-q.z, 1e-4);
  vec2 straight = gl_FragCoord.xy / target_size;
  return straight + clamp(0.5 * ndc + 0.5 - straight, -0.08, 0.08);
}

// The share of what a liquid's surface reflects in air that it does reflect: where it faces sideways or down it mostly
// stands against a wall, which leaves no air to be reflected from, and at a glance would show windows all the same.
float free_surface(vec3 normal) {
  return mix(kAgainstWalls, 1.0, smoothstep(0.1, 0.5, in_world(normal).z));
}

// look: roughness, haze [1/m], f0, metallic. What is clear and a metal does not occur.
vec3 clear_medium(vec3 p, vec3 normal, vec3 to_eye, vec4 tint, vec4 look) {
  vec2 uv = gl_FragCoord.xy / target_size;
  // what stands in the medium ends it
  float room = max(linear_depth(texture2D(scene_depth, uv).r) + p.z, 0.0);
  float thick = max(min(tint.a, room), 1e-6);
  float root = sqrt(clamp(look.z, 0.0, 0.6));
  vec2 bent = bent_to(p, normal, to_eye, (1.0 + root) / (1.0 - root), min(thick, 0.15));
  // what is in front of the surface is not seen through it
  if (linear_depth(texture2D(scene_depth, bent).r) < -p.z) bent = uv;
  vec3 absorption = tint.rgb / max(tint.a, 1e-6);
  vec2 shares = light_shares(p + lift * normal, normal);
  float hazy = 1.0 - exp(-thick * look.y);
  vec3 lit = light_of(texture2D(scene_color, bent).rgb) * exp(-absorption * thick);
  if (hazy > 0.004) {
    // scattered light has wandered through several times what it takes to be scattered
    vec3 own = exp(-absorption * min(6.0 * min(thick, 1.0 / max(look.y, 1e-3)), kWandered));
    lit = mix(lit, scattered(own, 1.0, normal, shares), 0.8 * hazy);
  }
  return lit * (1.0 - look.z) + free_surface(normal) * reflected(vec3(look.z), look.x, normal, to_eye, shares);
}

// look: roughness, softness, f0, metallic.
vec3 opaque_medium(vec3 p, vec3 normal, vec3 to_eye, vec3 color, vec4 look, float near_skin) {
  vec3 lit = shade(color, look.x, look.w, look.z, look.y, normal, to_eye, light_shares(p + lift * normal, normal));
  // what is thin lets the room's light through, which takes on the colour once more
  float through = look.y * exp(-near_skin * (1.0 - look.y) / max(0.003 * look.y, 1e-5));
  return lit + color * color * room_light(-normal) * through;
}

void main() {
  vec4 outlines = texture2D(outline, gl_FragCoord.xy / target_size);
  bool nearer = outlines.w >= 0.5;  // of two layers
  vec2 texels_per_pixel = surface_size / target_size, place = gl_FragCoord.xy * texels_per_pixel;
  // the outline fades over its last pixel
  float coverage = clamp((outlines.x - 0.5) / max(fwidth(outlines.x), 0.01) + 0.5, 0.0, 1.0);
  // at an outline the surface is that a little inside, as there each bead turns away from the eye
  float enclosed = min(outlines.x, outlines.y);
  vec2 inward = vec2(enclosed_at(vec2(1.0, 0.0)) - enclosed, enclosed_at(vec2(0.0, 1.0)) - enclosed);
  if (coverage <= 0.0) discard;
  float spread_pixels = 0.5 * target_size.y * gl_ProjectionMatrix[1][1] * spread * outlines.x / outlines.z;
  float least_slope = kLeastSlope / spread_pixels;
  float way = clamp(kInside - enclosed, 0.0, kInside) / max(dot(inward, inward), least_slope * least_slope);
  vec2 inside = place + way * inward * texels_per_pixel;
  vec2 s = surface_at(inside, nearer);
  if (s.x <= 0.0) discard;
  vec3 q = eye_point(inside, s.x);
  vec3 right = slope(inside, q, vec2(1.0, 0.0), nearer), up = slope(inside, q, vec2(0.0, 1.0), nearer);
  vec3 normal = normalize(cross(right, up));
  vec3 p = flat_from(q, normal, eye_point(place, 1.0));
  if (ended_by_walls) {
    bool in_hollow = (floatBitsToInt(texelFetch(surface, ivec2(inside), 0).r) & 1) == 1;
    coverage *= end_at_walls(in_hollow, place, texels_per_pixel, p, normal);
    if (coverage <= 0.0) discard;
  }
  vec3 to_eye = normalize(-p);
  if (dot(normal, to_eye) < 0.0) normal = -normal;
  vec4 tint = vec4(to_linear(own_tint.rgb), own_tint.a), look = own_look;
  if (one_tint && is_clear) {
    float thick = texture2D(tints, gl_FragCoord.xy / target_size).r;
    tint = vec4(own_tint.rgb, 1.0) * thick;
  } else if (!one_tint) {
    tint = texture2D(tints, gl_FragCoord.xy / target_size);
    if (!is_clear && tint.a < 1e-7) discard;
    look = texture2D(surface_looks, gl_FragCoord.xy / target_size) / max(tint.a, 1e-6);
    if (!is_clear) tint.rgb /= max(tint.a, 1e-6);
  }
  // a bend that is narrower than a pixel mixes what it reflects (Kaplanyan and others, 2016)
  vec3 turn_x = dFdx(normal), turn_y = dFdy(normal);
  float rough = look.x * look.x;
  look.x = sqrt(sqrt(rough * rough + min(0.5 * (dot(turn_x, turn_x) + dot(turn_y, turn_y)), 0.18)));
  vec3 lit;
  if (is_clear) {
    lit = clear_medium(p, normal, to_eye, tint, look);
  } else if (by_scalar) {
    float t = clamp((s.y - value_range.x) / (value_range.y - value_range.x), 0.0, 1.0);
    vec3 color = to_linear(textureLod(color_map, (t * 255.0 + 0.5) / 256.0, 0.0).rgb);
    // matt: a reflection would falsify what the colour says
    lit = scattered(color, 0.2, normal, light_shares(p + lift * normal, normal));
  } else {
    lit = opaque_medium(p, normal, to_eye, tint.rgb, look, tint.a);
  }
  float ndc = (gl_ProjectionMatrix[2][2] * p.z + gl_ProjectionMatrix[3][2]) / -p.z;
  gl_FragDepth = clamp(0.5 * ndc + 0.5, 0.0, 1.0);
  gl_FragColor = vec4(display(lit), coverage);
}
