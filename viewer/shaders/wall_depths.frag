#version 330 compatibility
// Where a ray first goes into a hollow solid, comes out of it into its hollow, comes out of it on the other side, and
// leaves its hollow [m]; each is the least of all faces of its kind. A surface that lies in the plane of an outer face
// counts as within.
uniform bool inner;        // these faces look into the hollow
uniform float wall_slack;  // [m] before and behind outer faces

in float depth;

const float kNowhere = 1e30;

void main() {
  float into = inner ? depth : depth - wall_slack;
  gl_FragColor = vec4(gl_FrontFacing ? into : kNowhere, !gl_FrontFacing && inner ? depth : kNowhere,
                      !gl_FrontFacing && !inner ? depth + wall_slack : kNowhere,
                      gl_FrontFacing && inner ? depth : kNowhere);
}
