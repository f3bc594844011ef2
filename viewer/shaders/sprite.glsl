#version 330 compatibility
// Returns the depth (clip space) of a sprite at this place whose sphere begins at front, seen along the view [m, negative
// before the eye]: no part of the sphere is nearer. What is nearer than the near plane stays there, and nothing is moved there.
float front_depth(float front, vec4 at) {
  if (at.z < -at.w) return at.z;
  if (front > -1e-4) return -at.w;
  return max((gl_ProjectionMatrix[2][2] * front + gl_ProjectionMatrix[3][2]) / -front, -1.0) * at.w;
}
