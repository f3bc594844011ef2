#version 330 compatibility
// One light model for particles, media and solids: a key light behind a window and a room around, which stand in the
// world. Light is linear; display() of color.glsl turns it into a colour of the screen. A light of 1 is what makes a white,
// matt surface white.
uniform mat4 osg_ViewMatrix;
uniform sampler2DShadow shadow_map;
uniform mat4 shadow_from_eye;
uniform float shadow_texel;  // [m]

const vec3 kKeyLight = vec3(0.90, 0.86, 0.79);
const float kPi = 3.14159265;

// The direction to the key light, as the eye sees it.
vec3 key_light() { return normalize(mat3(osg_ViewMatrix) * vec3(-0.42, -0.50, 0.76)); }

// A direction that the eye sees, in the world.
vec3 in_world(vec3 direction) { return transpose(mat3(osg_ViewMatrix)) * direction; }

// How much of a pane around x = 0 is seen through a blur of that half width.
float pane(float x, float half_width, float blur) {
  return smoothstep(-blur, blur, x + half_width) - smoothstep(-blur, blur, x - half_width);
}

// A window in the direction forward, beside which is right and above which is up, all of unit length.
float window(vec3 world, vec3 forward, vec3 right, vec3 up, vec2 size, float blur) {
  float ahead = dot(world, forward);
  vec2 p = vec2(dot(world, right), dot(world, up)) / max(ahead, 0.05);
  return ahead > 0.05 ? pane(p.x, size.x, blur) * pane(p.y, size.y, blur) : 0.0;
}

// What shiny things reflect: a table, walls and a bright ceiling, a window with a cross where the key light is, another
// one behind and a lamp to the right, as a surface of that roughness mixes them.
vec3 environment(vec3 direction, float roughness) {
  vec3 world = in_world(direction);
  float blur = 0.03 + 0.9 * roughness;
  vec3 room = mix(vec3(0.20, 0.175, 0.15), vec3(0.33, 0.34, 0.36), smoothstep(-0.10 - blur, 0.16 + blur, world.z));
  room = mix(room, vec3(0.56, 0.58, 0.60), smoothstep(0.45 - blur, 0.70 + blur, world.z));
  vec3 ahead = vec3(-0.4192, -0.4991, 0.7586), right = vec3(0.7657, -0.6432, 0.0), up = vec3(0.4880, 0.5808, 0.6515);
  float front = window(world, ahead, right, up, vec2(0.30, 0.40), blur);
  vec2 cross_at = vec2(dot(world, right), dot(world, up)) / max(dot(world, ahead), 0.05);
  front *= 1.0 - max(0.0, 1.0 - 4.0 * roughness) * max(pane(cross_at.x, 0.018, 0.012), pane(cross_at.y, 0.018, 0.012));
  float back = window(world, vec3(0.3511, 0.8026, 0.4816), vec3(0.9162, -0.4008, 0.0), vec3(0.1930, 0.4412, 0.8764),
                      vec2(0.42, 0.20), blur);
  float lamp = window(world, vec3(0.9138, -0.1523, 0.3766), vec3(-0.1644, -0.9864, 0.0), vec3(0.3715, -0.0619, 0.9264),
                      vec2(0.10, 0.35), blur);
  return room + vec3(2.9, 2.8, 2.6) * front + vec3(1.15, 1.30, 1.50) * back + vec3(1.30, 0.95, 0.65) * lamp;
}

// The room's light on a matt surface.
vec3 room_light(vec3 normal) {
  vec3 world = in_world(normal);
  vec3 sky = mix(vec3(0.15, 0.135, 0.12), vec3(0.40, 0.43, 0.47), world.z * 0.5 + 0.5);
  return sky + vec3(0.06, 0.065, 0.075) * max(dot(world, vec3(0.35, 0.80, 0.48)), 0.0) +
         vec3(0.07, 0.05, 0.03) * max(dot(world, vec3(0.91, -0.15, 0.38)), 0.0);
}

// The shares, 0 .. 1, of the key light and of the room's light that reach a point: the room's is what a wider look at the
// same map finds free. The point is lifted off its surface by more than a texel, or surfaces would shade themselves.
vec2 light_shares(vec3 eye_point, vec3 normal) {
  vec4 p = shadow_from_eye * vec4(eye_point + 1.5 * shadow_texel * normal, 1.0);
  vec4 q = shadow_from_eye * vec4(eye_point + 9.0 * shadow_texel * normal, 1.0);
  vec2 texel = 1.0 / vec2(textureSize(shadow_map, 0));
  float key = 0.0, room = 0.0;
  for (int i = 0; i < 4; ++i) {
    vec2 side = vec2(float(i & 1), float(i >> 1)) * 2.0 - 1.0;
    key += texture(shadow_map, p.xyz + vec3(1.2 * side * texel, 0.0));
    room += texture(shadow_map, q.xyz + vec3(9.0 * mat2(0.8, 0.6, -0.6, 0.8) * side * texel, 0.0));
  }
  return vec2(0.25 * key, 0.3 + 0.175 * room);
}

// What a surface reflects, without what comes from below it; f0: its reflection where one looks straight at it. After
// Karis (2013 and 2014): GGX, and an environment that stands for all directions that the surface mixes.
vec3 reflected(vec3 f0, float roughness, vec3 normal, vec3 to_eye, vec2 shares) {
  float facing = clamp(dot(normal, to_eye), 1e-3, 1.0);
  vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float a004 = min(r.x * r.x, exp2(-9.28 * facing)) * r.x + r.y;
  vec2 scale = vec2(-1.04, 1.04) * a004 + r.zw;
  vec3 share = f0 * scale.x + scale.y;
  vec3 seen = environment(reflect(-to_eye, normal), roughness) * (0.35 + 0.65 * shares.y) * share;
  // the key light is as wide as a lamp behind its window
  float alpha = max(roughness * roughness, 0.045);
  vec3 key = key_light();
  vec3 half_way = normalize(key + to_eye);
  float n_h = clamp(dot(normal, half_way), 0.0, 1.0), n_l = clamp(dot(normal, key), 0.0, 1.0);
  float d = n_h * n_h * (alpha * alpha - 1.0) + 1.0;
  float visible = 0.25 / mix(2.0 * n_l * facing, n_l + facing, alpha);
  float bright = min(alpha * alpha / (d * d) * 2.0 * visible * n_l, 24.0);
  return seen + kKeyLight * (shares.x * bright) * share;
}

// Light that comes back from below a surface of that linear colour. softness, 0 .. 1: how far it goes there, so that it
// comes out beyond the edge of a shadow, and of its own colour there.
vec3 scattered(vec3 color, float softness, vec3 normal, vec2 shares) {
  vec3 spread = softness * (0.25 + 0.75 * color);
  vec3 wrap = 0.12 + 0.55 * spread;
  vec3 lit = clamp((dot(normal, key_light()) + wrap) / (1.0 + wrap), 0.0, 1.0);
  vec3 share = mix(vec3(shares.x), vec3(sqrt(shares.x)), spread);
  return color * (room_light(normal) * shares.y + kKeyLight * share * lit * mix(vec3(1.0), lit, 0.45));
}

// f0 is that of what is no metal. A metal reflects in its colour and scatters nothing.
vec3 shade(vec3 color, float roughness, float metallic, float f0, float softness, vec3 normal, vec3 to_eye, vec2 shares) {
  vec3 sent_back = mix(vec3(f0), color, metallic);
  vec3 below = scattered(color, softness, normal, shares) * ((1.0 - metallic) * (1.0 - f0));
  return below + reflected(sent_back, roughness, normal, to_eye, shares);
}
