#version 330 compatibility
// One light model for particles and meshes: a key light and a sky that stand in the world, a faint fill from the eye.
// Colours go in and out as sRGB; a square stands in for the transfer curve, as it costs a software rasteriser little.
uniform mat4 osg_ViewMatrix;
uniform sampler2DShadow shadow_map;
uniform mat4 shadow_from_eye;
uniform float shadow_texel;  // [m]

// The direction to the key light, as the eye sees it.
vec3 key_light() { return normalize(mat3(osg_ViewMatrix) * vec3(-0.42, -0.50, 0.76)); }

// What shiny things reflect: a dim room with two soft windows, linear.
vec3 environment(vec3 direction) {
  vec3 world = transpose(mat3(osg_ViewMatrix)) * direction;
  vec3 room = mix(vec3(0.09, 0.095, 0.105), vec3(0.42, 0.47, 0.53), smoothstep(-0.3, 1.0, world.z));
  float left = smoothstep(0.78, 0.92, dot(world, normalize(vec3(-0.42, -0.50, 0.76))));
  float back = smoothstep(0.86, 0.95, dot(world, normalize(vec3(0.35, 0.80, 0.48))));
  return room + vec3(1.9, 1.85, 1.75) * left + vec3(0.9, 1.0, 1.15) * back;
}

// The share of the key light that reaches a point, 0 .. 1. The point is lifted off its surface by more than a texel, or
// surfaces would shade themselves.
float key_share(vec3 eye_point, vec3 normal) {
  vec4 p = shadow_from_eye * vec4(eye_point + 1.5 * shadow_texel * normal, 1.0);
  float sum = 0.0;
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      sum += texture(shadow_map, p.xyz + vec3(1.5 * vec2(x, y) / vec2(textureSize(shadow_map, 0)), 0.0));
    }
  }
  return sum / 9.0;
}

vec3 shade(vec3 color, vec3 normal, vec3 to_eye, float gloss, float rim, float share) {
  mat3 view = mat3(osg_ViewMatrix);
  vec3 up = view[2];
  vec3 key = key_light();
  vec3 albedo = color * color;
  float facing = max(dot(normal, to_eye), 0.0);
  float wrapped = max((dot(normal, key) + 0.25) / 1.25, 0.0);
  vec3 sky = mix(vec3(0.20, 0.18, 0.17), vec3(0.44, 0.48, 0.54), dot(normal, up) * 0.5 + 0.5);
  vec3 light = sky * (0.7 + 0.3 * share) + vec3(0.86, 0.83, 0.78) * (share * wrapped * wrapped) + vec3(0.10) * facing;
  float grazing = 1.0 - facing;
  float highlight = max(dot(normal, normalize(key + to_eye)), 0.0);
  highlight *= highlight;
  highlight *= highlight;
  highlight *= highlight;
  highlight *= highlight;
  highlight *= highlight;
  vec3 lit = albedo * light + vec3(share * gloss * highlight) + vec3(0.55, 0.65, 0.8) * rim * grazing * grazing * grazing;
  return sqrt(min(lit, vec3(1.0)));
}
