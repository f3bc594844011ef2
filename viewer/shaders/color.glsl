#version 330 compatibility
// Between light and what a screen shows of it. Light is linear and has no upper end; what is shown is sRGB.
const float kLinearTo = 0.55;  // up to here a screen shows light as it is; brighter light comes ever closer to white

vec3 to_linear(vec3 shown) {
  return mix(shown / 12.92, pow((shown + 0.055) / 1.055, vec3(2.4)), greaterThan(shown, vec3(0.04045)));
}

vec3 to_srgb(vec3 share) {
  return mix(12.92 * share, 1.055 * pow(share, vec3(1.0 / 2.4)) - 0.055, greaterThan(share, vec3(0.0031308)));
}

// No light is so strong that a stronger one looks the same.
vec3 display(vec3 light) {
  light = max(light, vec3(0.0));
  vec3 beyond = max(light - kLinearTo, vec3(0.0));
  return to_srgb(min(light, vec3(kLinearTo)) + (1.0 - kLinearTo) * beyond / (beyond + (1.0 - kLinearTo)));
}

// The light that is displayed so; white counts as twenty times as bright as what is shown half as bright.
vec3 light_of(vec3 shown) {
  vec3 share = to_linear(shown);
  vec3 beyond = min(max(share - kLinearTo, vec3(0.0)) / (1.0 - kLinearTo), vec3(0.95));
  return min(share, vec3(kLinearTo)) + (1.0 - kLinearTo) * beyond / (1.0 - beyond);
}
