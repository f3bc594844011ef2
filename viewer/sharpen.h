// Gives a surface back the edges that a lattice cut off.
#pragma once

#include "viewer/welded_surface.h"

namespace palp {

// A surface that was sampled on a lattice from a solid of boxes, spheres and cylinders has all of its vertices on
// these, but its edges are cut off, so that rims look jagged. Finds out what the vertices lie on, lets triangles that
// cut an edge off end at it instead, and notes for each triangle the primitive that it lies on, whose normals are
// exact. A surface of any other kind stays as it is, and so does one whose edges differ much in length: it is exact.
void sharpen(Surface& surface);

}  // namespace palp
