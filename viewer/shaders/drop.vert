#version 330 compatibility
// A drop: gl_Vertex.xyz is its middle in the world, gl_Vertex.w how much of a particle it is; gl_MultiTexCoord0.xyz its
// velocity [m/s] and .w how white that makes it (its fraction) and how it falls apart (a number); gl_Color as for medium.vert.
uniform float picture_height;  // [pixels]
uniform float radius;          // of a whole particle's drop [m]
uniform sampler2D looks;       // as medium.vert has them, and whether one looks through it and how much it foams

flat out vec3 center;
flat out vec3 axis;           // along which it is stretched, of unit length
flat out vec2 half_lengths;   // across and along it [m]
flat out float own;           // the radius that it has as a ball [m]
flat out float sprite;        // radius [m]
flat out float apart;         // how far it has fallen apart, 0 .. 1
flat out mat3 turn;           // of its parts
flat out vec4 color;          // linear, and how much of the light comes from white
flat out vec4 depth_of_color;
flat out vec4 surface_look;
flat out float is_clear;
flat out float pixel_radius;

const float kShutter = 0.004;     // [s] of its way that a drop is stretched over
const float kMostStretch = 1.3;
const float kPartsReach = 2.2;    // of the middles of parts, as drop.frag has them

vec3 to_linear(vec3 shown);

// A rotation of its own for each number: three angles that hardly ever come together again.
mat3 rotation(float number) {
  vec3 angle = 6.2831853 * fract(number * vec3(0.6180340, 0.7548777, 0.8191725));
  vec3 c = cos(angle), s = sin(angle);
  return mat3(c.x, s.x, 0.0, -s.x, c.x, 0.0, 0.0, 0.0, 1.0) * mat3(1.0, 0.0, 0.0, 0.0, c.y, s.y, 0.0, -s.y, c.y) *
         mat3(c.z, s.z, 0.0, -s.z, c.z, 0.0, 0.0, 0.0, 1.0);
}

void main() {
  vec4 eye = gl_ModelViewMatrix * vec4(gl_Vertex.xyz, 1.0);
  center = eye.xyz;
  int row = int(gl_Color.a * 255.0 + 0.5);
  depth_of_color = texelFetch(looks, ivec2(0, row), 0);
  surface_look = texelFetch(looks, ivec2(1, row), 0);
  vec2 more = texelFetch(looks, ivec2(2, row), 0).xy;
  is_clear = more.x;
  color = vec4(to_linear(gl_Color.rgb), more.y * fract(gl_MultiTexCoord0.w));
  vec3 motion = mat3(gl_ModelViewMatrix) * gl_MultiTexCoord0.xyz;
  float speed = length(motion);
  axis = speed > 1e-6 ? motion / speed : vec3(0.0, 0.0, 1.0);
  own = radius * pow(gl_Vertex.w, 1.0 / 3.0);
  float stretch = 1.0 + (kMostStretch - 1.0) * (1.0 - exp(-kShutter * speed / (radius * (kMostStretch - 1.0))));
  half_lengths = own * vec2(inversesqrt(stretch), stretch);  // the same volume
  apart = color.w;
  turn = mat3(gl_ModelViewMatrix) * rotation(floor(gl_MultiTexCoord0.w));
  sprite = half_lengths.y + kPartsReach * apart * own;
  gl_Position = gl_ProjectionMatrix * eye;
  float pixels = picture_height * gl_ProjectionMatrix[1][1] / gl_Position.w;  // of two metres
  gl_PointSize = max(pixels * sprite, 1.0);
  pixel_radius = 0.5 * pixels * half_lengths.x;
  // what is nothing but part of the surface has white around it alone
  if (own <= 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}
