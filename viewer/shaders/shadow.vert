#version 330 compatibility
// Surfaces and particles as the key light sees them.
uniform float target_height;  // [pixels]
uniform float radius;         // of a particle [m]
uniform float sink;           // away from the light [m]: beads must not shade the smooth surface that stands for them
uniform vec4 clip_plane;     // to the light; what it cuts away is negative

void main() {
  vec4 seen = gl_ModelViewMatrix * vec4(gl_Vertex.xyz, 1.0);
  gl_ClipDistance[0] = dot(clip_plane, seen);
  seen.z -= sink;
  gl_Position = gl_ProjectionMatrix * seen;
  gl_PointSize = max(target_height * gl_ProjectionMatrix[1][1] * radius, 1.0);
}
