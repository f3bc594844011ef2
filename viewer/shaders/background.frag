#version 330 compatibility
in vec2 at;

void main() {
  vec3 low = vec3(0.205, 0.225, 0.255);
  vec3 high = vec3(0.085, 0.098, 0.120);
  float t = 0.5 + 0.5 * at.y;
  vec3 c = mix(low, high, t * t * (3.0 - 2.0 * t));
  c *= 1.0 - 0.10 * dot(at, at);
  // a step of noise below one grey level keeps the gradient from showing bands
  float dither = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  gl_FragColor = vec4(c + dither / 255.0, 1.0);
}
