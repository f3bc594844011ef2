#version 330 compatibility
// A drop, an ellipsoid drawn on a point sprite: looked through as a lens where its liquid is clear, and whiter the more
// it foams. What is so fast that it foams falls apart into smaller ones, which together hold as much: a particle is much
// larger than a drop that stays whole in the air.
flat in vec3 center;
flat in vec3 axis;
flat in vec2 half_lengths;
flat in float own;
flat in float sprite;
flat in float apart;
flat in mat3 turn;
flat in vec4 color;
flat in vec4 depth_of_color;  // absorption and haze [1/m]
flat in vec4 surface_look;    // roughness, softness, f0, metallic
flat in float is_clear;
flat in float pixel_radius;

vec3 shade(vec3 color, float roughness, float metallic, float f0, float softness, vec3 normal, vec3 to_eye, vec2 shares);
vec3 reflected(vec3 f0, float roughness, vec3 normal, vec3 to_eye, vec2 shares);
vec3 scattered(vec3 color, float softness, vec3 normal, vec2 shares);
vec3 environment(vec3 direction, float roughness);
vec3 key_light();
vec2 light_shares(vec3 eye_point, vec3 normal);
vec3 display(vec3 light);

const vec3 kFoam = vec3(0.92, 0.94, 0.95);
// How much of what is behind it a clear drop hides in its middle and at its rim, and what a white one hides.
const float kMiddle = 0.15, kRim = 0.65, kWhite = 0.6;

// The parts, the whole as a ball of radius 1 about 0: their middles, spread out as they fly, and their radii.
const vec4 kParts[12] = vec4[12](
    vec4(1.32, -0.40, -0.74, 0.25), vec4(1.14, 1.78, -0.61, 0.45), vec4(-0.26, 0.70, -1.52, 0.49),
    vec4(-1.62, 0.13, -0.85, 0.16), vec4(-1.18, -0.46, -0.61, 0.26), vec4(-0.49, -0.82, 0.72, 0.61),
    vec4(1.62, -0.70, -1.32, 0.20), vec4(0.88, 0.95, -1.30, 0.25), vec4(0.79, 0.65, 0.62, 0.61),
    vec4(-1.52, 0.58, 0.36, 0.50), vec4(0.94, -1.33, -0.56, 0.39), vec4(-0.34, -2.15, -0.31, 0.45));

// What is seen through a clear drop: the room behind it, upside down.
vec3 through(vec3 normal, vec3 to_eye, vec2 shares, float part_radius) {
  float root = sqrt(clamp(surface_look.z, 0.0, 0.6)), index = (1.0 + root) / (1.0 - root);
  vec3 in_drop = refract(-to_eye, normal, 1.0 / index);
  float chord = -2.0 * dot(in_drop, normal);  // in radii
  vec3 far = normal + chord * in_drop;
  vec3 beyond = refract(in_drop, -far, index);
  float thick = chord * half_lengths.x * part_radius;
  vec3 seen = environment(beyond, surface_look.x) * (0.35 + 0.65 * shares.y) * exp(-depth_of_color.rgb * thick);
  float hazy = 1.0 - exp(-thick * depth_of_color.a);
  return mix(seen, scattered(exp(-depth_of_color.rgb * 6.0 * thick), 1.0, normal, shares), 0.8 * hazy);
}

void main() {
  vec2 q = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);
  float across = 1.0 / (half_lengths.x * half_lengths.x), more = 1.0 / (half_lengths.y * half_lengths.y) - across;
  // where a line along the view meets an ellipsoid first: a z^2 + 2 b z + c = 0
  float a = across + more * axis.z * axis.z, part_radius = 0.0, rim = 0.0, z = -1e30;
  vec3 at;  // from the part's middle
  for (int k = 0; k < (apart > 0.0 ? 12 : 1); ++k) {
    vec3 middle = apart * own * (turn * kParts[k].xyz), from = vec3(q * sprite, 0.0) - middle;
    float r = mix(1.0, kParts[k].w, apart), along = dot(from, axis);
    float b = across * from.z + more * axis.z * along;
    float c = across * dot(from, from) + more * along * along - r * r;
    float root2 = b * b - a * c;
    if (root2 <= 0.0 || (sqrt(root2) - b) / a < z) continue;
    z = (sqrt(root2) - b) / a;
    at = from + vec3(0.0, 0.0, z);
    part_radius = r;
    rim = sqrt(root2 / a) / r;  // the share of the way to the middle
  }
  if (part_radius <= 0.0) discard;
  vec3 p = center + vec3(q * sprite, z);
  if (p.z > -1e-4) discard;
  vec3 normal = normalize(across * at + more * dot(at, axis) * axis);
  vec3 to_eye = normalize(-p);
  if (dot(normal, to_eye) < 0.02) normal = normalize(normal + (0.02 - dot(normal, to_eye)) * to_eye);
  vec2 shares = light_shares(p, normal);
  vec3 lit;
  float hides = 1.0;  // of what is behind it
  if (is_clear > 0.5) {
    vec3 mirrored = reflected(vec3(surface_look.z), surface_look.x, normal, to_eye, shares);
    // a ball gathers light on the side that is turned away from it
    float gathered = max(dot(normal, normalize(to_eye - 1.2 * key_light())), 0.0);
    vec3 shining = vec3(0.9 * shares.x * pow(gathered, 6.0));
    lit = through(normal, to_eye, shares, part_radius) * (1.0 - surface_look.z) + mirrored + shining;
    float facing = dot(normal, to_eye);
    hides = clamp(mix(kRim, kMiddle, facing) + dot(mirrored + shining, vec3(0.3333)), 0.0, 1.0);
  } else {
    lit = shade(color.rgb, surface_look.x, surface_look.w, surface_look.z, surface_look.y, normal, to_eye, shares);
  }
  lit = mix(lit, scattered(kFoam, 0.4, normal, shares), 0.6 * color.w);
  hides = mix(hides, max(hides, kWhite), color.w);
  float ndc = (gl_ProjectionMatrix[2][2] * p.z + gl_ProjectionMatrix[3][2]) / -p.z;
  gl_FragDepth = clamp(0.5 * ndc + 0.5, 0.0, 1.0);
  // the rim fades over its last pixel
  gl_FragColor = vec4(display(lit), hides * clamp(0.5 * rim * rim * part_radius * pixel_radius, 0.0, 1.0));
}
