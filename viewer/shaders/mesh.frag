#version 330 compatibility
// Solid surfaces; with glass > 0 a wall that one looks through: clear face on, denser and brighter at a glancing angle.
uniform float glass;
uniform vec4 tint;          // a colour and its share
uniform float presence;     // of what fades in
uniform float ghost;        // > 0: what lies hidden behind other things shows through, this strongly
uniform vec4 surface_look;  // roughness, softness, f0, metallic
uniform vec4 grain;         // the way that it runs in the body's frame, and its contrast

in vec3 eye_position;
in vec3 eye_normal;
in vec3 body_position;
in vec4 color;

vec3 shade(vec3 color, float roughness, float metallic, float f0, float softness, vec3 normal, vec3 to_eye, vec2 shares);
vec3 reflected(vec3 f0, float roughness, vec3 normal, vec3 to_eye, vec2 shares);
vec2 light_shares(vec3 eye_point, vec3 normal);
vec3 display(vec3 light);
vec3 to_linear(vec3 shown);

const float kRing = 0.006;  // [m] from one ring of wood to the next

// Rings around an axis beside the body, wavy along it: late wood is dark. Where rings are too narrow for pixels, none.
float dark_wood(vec3 p, vec3 along) {
  float way = dot(p, along);
  vec3 across = p - along * way;
  across += vec3(0.071, -0.053, 0.093) + 0.004 * sin(vec3(17.0, 13.0, 11.0) * way + 40.0 * across.yzx);
  float ring = length(across - along * dot(across, along)) / kRing;
  float late = fract(ring + 0.15 * sin(7.0 * way / 0.1));
  float width = clamp(1.0 - fwidth(ring), 0.0, 1.0);
  float fiber = 0.5 + 0.5 * sin(dot(across, vec3(2100.0, 2700.0, 1900.0)) + 3.0 * sin(30.0 * way));
  return (0.8 * late * late * (1.0 - smoothstep(0.9, 1.0, late)) + 0.2 * fiber) * width;
}

void main() {
  vec3 to_eye = normalize(-eye_position);
  vec3 normal = normalize(eye_normal);
  if (dot(normal, to_eye) < 0.0) normal = -normal;
  vec3 own = to_linear(mix(color.rgb, tint.rgb, tint.a));
  if (grain.w > 0.0) own *= 1.0 - grain.w * dark_wood(body_position, grain.xyz);
  vec2 shares = light_shares(eye_position, normal);
  float alpha = color.a;
  vec3 lit;
  if (glass > 0.0) {
    float grazing = 1.0 - max(dot(normal, to_eye), 0.0);
    float steep = grazing * grazing * grazing;
    alpha = glass + (0.55 - glass) * steep;
    vec3 mirrored = reflected(vec3(surface_look.z), min(surface_look.x, 0.1), normal, to_eye, vec2(1.0)) / alpha;
    lit = mix(0.5 * own * (0.3 + 0.7 * shares.y) + mirrored, to_linear(tint.rgb), 0.5 * tint.a);
  } else {
    lit = shade(own, surface_look.x, surface_look.w, surface_look.z, surface_look.y, normal, to_eye, shares);
  }
  if (ghost > 0.0) alpha = ghost;
  gl_FragColor = vec4(display(lit), alpha * presence);
}
