#version 330 compatibility
// A particle of a medium that is drawn as a surface: gl_Vertex.xyz is its centre in the world, gl_Color.rgb its body's
// colour and gl_Color.a which look it has, and from 128 on that it is seen in the hollow of a solid alone
// (LookTable::kInHollow). gl_Vertex.w is its scalar where colours show that (below -1e38: it has none), else how much of
// it is part of the surface: the rest is a drop. Or a lump of particles: gl_Vertex.xyz is their middle and gl_Vertex.w
// how many particles it has of those that would fill it.
uniform float target_height;  // [pixels]
uniform float radius;         // of a particle's sprite [m]
uniform float sink;           // [m], as medium_depth.frag has it
uniform float lump_over_spacing;  // the side of a lump; 1: these are particles
uniform bool by_scalar;
uniform vec2 value_range;
uniform sampler2D looks;  // a row a look: absorption [1/m] and haze [1/m]; roughness, softness, f0 and metallic

flat out vec3 center;
flat out float weight;  // of a lump, or of what is part of the surface
flat out float size;    // of that part, of a whole particle
flat out vec3 tint;  // linear
flat out float scalar;
flat out int in_hollow;
flat out vec4 depth_of_color;  // absorption and haze
flat out vec4 surface_look;

vec3 to_linear(vec3 shown);
float front_depth(float front, vec4 at);

void main() {
  vec4 eye = gl_ModelViewMatrix * vec4(gl_Vertex.xyz, 1.0);
  center = eye.xyz;
  tint = to_linear(gl_Color.rgb);
  int row = int(gl_Color.a * 255.0 + 0.5);
  in_hollow = row >> 7;
  row &= 127;
  depth_of_color = texelFetch(looks, ivec2(0, row), 0);
  surface_look = texelFetch(looks, ivec2(1, row), 0);
  weight = by_scalar ? 1.0 : gl_Vertex.w;
  size = lump_over_spacing > 1.0 || weight >= 1.0 ? 1.0 : pow(weight, 1.0 / 3.0);
  scalar = gl_Vertex.w > -1e38 ? gl_Vertex.w : value_range.x;
  gl_Position = gl_ProjectionMatrix * eye;
  gl_Position.z = front_depth(eye.z + size * (1.03 * radius - sink), gl_Position);
  gl_PointSize = max(target_height * gl_ProjectionMatrix[1][1] * size * radius * lump_over_spacing / gl_Position.w, 1.0);
  if (weight <= 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}
