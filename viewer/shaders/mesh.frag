#version 330 compatibility
// Solid surfaces; with glass > 0 a wall that one looks through: clear face on, denser and brighter at a glancing angle.
uniform float glass;
uniform vec4 tint;       // a colour and its share
uniform float presence;  // of what fades in
uniform float ghost;     // > 0: what lies hidden behind other things shows through, this strongly

in vec3 eye_position;
in vec3 eye_normal;
in vec4 color;

vec3 shade(vec3 color, vec3 normal, vec3 to_eye, float gloss, float rim, float share);
float key_share(vec3 eye_point, vec3 normal);
vec3 environment(vec3 direction);

void main() {
  vec3 to_eye = normalize(-eye_position);
  vec3 normal = normalize(eye_normal);
  if (dot(normal, to_eye) < 0.0) normal = -normal;
  vec3 lit = shade(mix(color.rgb, tint.rgb, tint.a), normal, to_eye, 0.18, 0.10, key_share(eye_position, normal));
  float alpha = color.a;
  if (glass > 0.0) {
    float grazing = 1.0 - max(dot(normal, to_eye), 0.0);
    float steep = grazing * grazing * grazing;
    alpha = glass + (0.55 - glass) * steep;
    vec3 reflected = sqrt(min(environment(reflect(-to_eye, normal)), vec3(1.0)));
    lit = mix(mix(lit, reflected, 0.75), tint.rgb, 0.5 * tint.a);
  }
  if (ghost > 0.0) alpha = ghost;
  gl_FragColor = vec4(lit, alpha * presence);
}
