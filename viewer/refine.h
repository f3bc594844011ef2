// Makes the triangles of a surface small, for one that bends.
#pragma once

#include "viewer/welded_surface.h"

namespace palp {

// Halves edges, and the triangles at them, until none is longer than so many metres (above 0), or the surface has a
// million triangles. The surface stays where it is.
void refine(Surface& surface, double longest_edge);

}  // namespace palp
