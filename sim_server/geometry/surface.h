// Surfaces of solids for display.
#pragma once

#include "sim_server/geometry/solid.h"

namespace palp {

// In the body frame. Boxes along common axes: their exact outer faces. Parts only added: the parts' surfaces side by
// side. Spheres and cylinders about one axis: their outline turned about it, exact within a hundredth of the solid's
// size at corners, with walls of a hundredth of it; parts that are added after all that is cut away stand beside it.
// Otherwise: the solid's surface from cells of `cell` metres, coarser when the solid is larger than 48 cells; its
// vertices lie on the surface, its edges are cut off within a cell.
SurfaceMesh solid_surface(const Solid& solid, double cell);

}  // namespace palp
