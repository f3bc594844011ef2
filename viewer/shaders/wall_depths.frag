#version 330 compatibility
// Where a ray first goes into a hollow solid, comes out of it into its hollow, comes out of it on the other side, and
// leaves its hollow: one over the distance [1/m], 0 where it does not; each is that of the nearest face of its kind. So
// a GPU clears to zeros, which takes it no time. A surface that lies in the plane of an outer face counts as within.
uniform bool inner;        // these faces look into the hollow
uniform float wall_slack;  // [m] before and behind outer faces

in float depth;

float near(float distance) { return 1.0 / max(distance, 1e-4); }

void main() {
  float into = inner ? depth : depth - wall_slack;
  gl_FragColor = vec4(gl_FrontFacing ? near(into) : 0.0, !gl_FrontFacing && inner ? near(depth) : 0.0,
                      !gl_FrontFacing && !inner ? near(depth + wall_slack) : 0.0,
                      gl_FrontFacing && inner ? near(depth) : 0.0);
}
