// The solids of bodies in the layout of the kernels that ask for distances from them and their shares. Host only.
#pragma once

#include <vector>

#include "sim_server/physics/distance.h"
#include "sim_server/physics/smoothing.h"
#include "sim_server/scene/scene.h"

namespace palp {

struct SolidShapes {
  std::vector<ContactBody> shape;     // without contact points
  std::vector<std::uint32_t> shaped;  // the bodies that these are of
  std::vector<Piece> piece;
  std::vector<NodeGrid> grid;  // without their nodes
  std::vector<Packed> node;    // of all grids, one after another

  // Returns the grids with their nodes from `node` on.
  std::vector<NodeGrid> grids_at(const Packed* node) const;
};

// Returns the solids of all bodies that have a contact shape, in the scene's order.
SolidShapes solid_shapes(const Scene& scene);

// Adds what shares of solids ask beyond distances: the profiles of cylinders.
void add_profiles(const FluidKernelOf<double>& kernel, SolidShapes& shapes);

// Marks those that have walls through which fluid particles would see each other. support: of fluids [m].
void mark_thin(const Scene& scene, double support, SolidShapes& shapes);

}  // namespace palp
