#version 330 compatibility
// A table top that fades out: grid lines, and the soft shadow of what stands on it.
uniform vec4 footprint;   // min x, min y, max x, max y of the things that stand on the ground [m]
uniform vec2 fade;        // distance from the footprint's centre: full, gone [m]
uniform float cell;       // grid [m]

in vec2 world;
in vec3 eye_position;

uniform mat4 osg_ViewMatrix;
vec2 light_shares(vec3 eye_point, vec3 normal);

float lines(float size, float width) {
  vec2 g = world / size;
  vec2 w = max(fwidth(g), vec2(1e-6));
  vec2 d = abs(fract(g - 0.5) - 0.5) / w;
  vec2 on = clamp(width - d, 0.0, 1.0) * clamp(0.45 / w - 1.0, 0.0, 1.0);
  return max(on.x, on.y);
}

void main() {
  vec2 middle = 0.5 * (footprint.xy + footprint.zw);
  float around = length(world - middle);
  float visible = 1.0 - smoothstep(fade.x, fade.y, around);
  vec2 outside = max(max(footprint.xy - world, world - footprint.zw), vec2(0.0));
  float reach = 0.16 * length(footprint.zw - footprint.xy);
  float near = clamp(1.0 - length(outside) / reach, 0.0, 1.0);
  // a soft one all around, and that of the key light
  float thrown = 0.45 * (1.0 - light_shares(eye_position, mat3(osg_ViewMatrix)[2]).x);
  float shadow = max(0.40 * near * near * near, thrown);
  float line = max(0.22 * lines(cell, 1.2), 0.42 * lines(5.0 * cell, 1.4));
  float alpha = max(shadow, line * (1.0 - shadow)) * visible;
  vec3 color = mix(vec3(0.02, 0.022, 0.026), vec3(0.62, 0.68, 0.76), line * (1.0 - shadow));
  gl_FragColor = vec4(color, alpha);
}
