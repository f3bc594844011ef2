#version 330 compatibility
// Solid surfaces; with glass > 0 a wall that one looks through: clear face on, denser and brighter at a glancing angle.
uniform float glass;
uniform vec4 tint;       // a colour and its share
uniform float presence;  // of what fades in
uniform float ghost;     // > 0: what lies hidden behind other things shows through, this strongly

in vec3 eye_position;
in vec3 eye_normal;
in vec4 color;

vec3 shade(vec3 color, vec3 normal, vec3 to_eye, float gloss, float rim);

void main() {
  vec3 to_eye = normalize(-eye_position);
  vec3 normal = normalize(eye_normal);
  if (dot(normal, to_eye) < 0.0) normal = -normal;
  vec3 lit = shade(mix(color.rgb, tint.rgb, tint.a), normal, to_eye, 0.18, 0.10);
  float alpha = color.a;
  if (glass > 0.0) {
    float grazing = 1.0 - max(dot(normal, to_eye), 0.0);
    alpha = glass + (0.55 - glass) * grazing * grazing * grazing;
    lit = mix(lit, mix(vec3(0.80, 0.87, 0.93), tint.rgb, tint.a), 0.5);
  }
  if (ghost > 0.0) alpha = ghost;
  gl_FragColor = vec4(lit, alpha * presence);
}
