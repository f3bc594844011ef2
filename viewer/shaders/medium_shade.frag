#version 330 compatibility
// The surface of a medium in the picture: lit where it is opaque; where it is clear, with what lies behind it, refracted
// and absorbed, and what it reflects.
uniform sampler2D surface;
uniform sampler2D tints;
uniform sampler2D surface_looks;  // as medium_tint.frag has them
uniform sampler2D outline;  // as medium_outline.frag has it
uniform sampler2D scene_color;
uniform sampler2D scene_depth;
uniform sampler1D color_map;
uniform vec2 target_size;   // of the picture [pixels]
uniform vec2 surface_size;  // [texels]
uniform vec2 tints_size;
uniform vec2 value_range;
uniform float range;  // of distances that belong to one surface [m]
uniform float lift;   // [m] off the surface, where its light is asked for
uniform bool by_scalar;
uniform bool is_clear;
uniform bool one_tint;   // all of it has this look: of a clear medium tints are its thickness alone, else there are none
uniform vec4 own_tint;   // sRGB and the depth that gives it [m]; or what a clear medium absorbs [1/m]
uniform vec4 own_look;

const float kCrease = 0.5;        // how much slopes to both sides differ at least
const float kInside = 0.8;       // of the surroundings are covered where the beads of an outline are not seen any more
const float kMostInward = 24.0;  // [pixels]
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

// The surface between texels, made of those at about the nearest distance; x is 0 where there is none.
vec2 surface_at(vec2 place) {
  ivec2 i = ivec2(floor(place - 0.5));
  vec2 t = place - 0.5 - vec2(i);
  vec2 s[4] = vec2[4](texelFetch(surface, i, 0).rg, texelFetch(surface, i + ivec2(1, 0), 0).rg,
                      texelFetch(surface, i + ivec2(0, 1), 0).rg, texelFetch(surface, i + ivec2(1, 1), 0).rg);
  vec4 w = vec4((1.0 - t.x) * (1.0 - t.y), t.x * (1.0 - t.y), (1.0 - t.x) * t.y, t.x * t.y);
  float nearest = 1e30;
  for (int k = 0; k < 4; ++k) nearest = s[k].x > 0.0 && w[k] > 0.01 ? min(nearest, s[k].x) : nearest;
  vec2 sum = vec2(0.0);
  float weights = 0.0;
  for (int k = 0; k < 4; ++k) {
    if (s[k].x <= 0.0 || s[k].x > nearest + range) continue;
    sum += w[k] * s[k];
    weights += w[k];
  }
  return weights > 0.0 ? sum / weights : vec2(0.0);
}

// The share of the place that has a surface.
float share_at(vec2 place) {
  ivec2 i = ivec2(floor(place - 0.5));
  vec2 t = place - 0.5 - vec2(i);
  vec4 s = vec4(texelFetch(surface, i, 0).r, texelFetch(surface, i + ivec2(1, 0), 0).r,
                texelFetch(surface, i + ivec2(0, 1), 0).r, texelFetch(surface, i + ivec2(1, 1), 0).r);
  return dot(vec4(greaterThan(s, vec4(0.0))),
             vec4((1.0 - t.x) * (1.0 - t.y), t.x * (1.0 - t.y), (1.0 - t.x) * t.y, t.x * t.y));
}

vec3 eye_point(vec2 place, float depth) {
  vec2 ndc = 2.0 * place / surface_size - 1.0;
  return vec3(ndc * depth / vec2(gl_ProjectionMatrix[0][0], gl_ProjectionMatrix[1][1]), -depth);
}

vec3 texel_point(ivec2 texel) { return eye_point(vec2(texel) + 0.5, texelFetch(surface, texel, 0).r); }

// The slope of that side of a crease which leads nearer to p, between the next two texels; 0 where one has no surface.
// A slope over the crease would be a bevel, which shines.
vec3 slope_beside(vec2 place, vec3 p, vec2 offset) {
  ivec2 texel = ivec2(floor(place)), step = ivec2(offset);
  vec3 a = texel_point(texel + step), b = texel_point(texel + 2 * step);
  vec3 c = texel_point(texel - step), d = texel_point(texel - 2 * step);
  if (max(max(a.z, b.z), max(c.z, d.z)) >= 0.0) return vec3(0.0);
  vec3 after = b - a, before = c - d;
  return abs(a.z - after.z - p.z) < abs(c.z + before.z - p.z) ? after : before;
}

// The smaller of the differences to both sides, so that an edge does not bend the normal on its near side.
vec3 slope(vec2 place, vec3 p, vec2 offset) {
  float after = surface_at(place + offset).x, before = surface_at(place - offset).x;
  vec3 forth = eye_point(place + offset, after) - p, back = p - eye_point(place - offset, before);
  if (after <= 0.0) return before <= 0.0 ? vec3(offset, 0.0) : back;
  if (before > 0.0 && abs(forth.z - back.z) > kCrease * length(forth.xy)) {
    vec3 at_crease = slope_beside(place, p, offset);
    if (at_crease != vec3(0.0)) return at_crease;
  }
  return before > 0.0 && abs(back.z) < abs(forth.z) ? back : forth;
}

// The place of the ray where the surface goes on flat from q, but not much farther.
vec3 flat_from(vec3 q, vec3 normal, vec3 ray) {
  float slant = dot(ray, normal);
  float depth = abs(slant) > 1e-4 ? dot(q, normal) / slant : 0.0;
  return ray * clamp(depth, -q.z, -q.z + range);
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
  float enclosed = texture2D(outline, gl_FragCoord.xy / target_size).r;
  vec2 place = gl_FragCoord.xy * surface_size / target_size;
  // what stands against the walls of a hollow ends there, and has no outline of its own
  bool in_hollow = (floatBitsToInt(texelFetch(surface, ivec2(place), 0).r) & 1) == 1;
  // the outline fades over its last pixel
  float coverage = clamp((enclosed - 0.5) / max(fwidth(enclosed), 0.01) + 0.5, 0.0, 1.0);
  if (in_hollow) coverage = 1.0;
  if (coverage <= 0.0) discard;
  // at the outline the surface is that a little inside, as there each bead turns away from the eye
  vec2 inward = vec2(dFdx(enclosed), dFdy(enclosed));
  float way = in_hollow ? 0.0 : clamp(kInside - enclosed, 0.0, kInside) / max(dot(inward, inward), 1e-6);
  vec2 inside = place + min(way, kMostInward / max(length(inward), 1e-3)) * inward * surface_size / target_size;
  // walls end the surface within its outline
  float share = share_at(place);
  coverage *= clamp((share - 0.5) / max(fwidth(share), 0.01) + 0.5, 0.0, 1.0);
  vec2 s = surface_at(inside);
  if (s.x <= 0.0 || coverage <= 0.0) discard;
  vec3 q = eye_point(inside, s.x);
  vec3 right = slope(inside, q, vec2(1.0, 0.0)), up = slope(inside, q, vec2(0.0, 1.0));
  vec3 normal = normalize(cross(right, up));
  vec3 p = flat_from(q, normal, eye_point(place, 1.0));
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
