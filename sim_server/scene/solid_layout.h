// The solids of bodies in the layout in which distances from them are asked for (physics/distance.h). Host only.
#pragma once

#include <vector>

#include "sim_server/physics/distance.h"
#include "sim_server/scene/scene.h"

namespace palp {

struct SolidLayout {
  std::vector<ContactBody> shape;
  std::vector<Piece> piece;
  std::vector<NodeGrid> grid;  // without their nodes
  std::vector<Packed> node;    // of all grids, one after another

  // Adds the solid of a body that has a distance field (Body::contact), without points and rounds of its surface.
  ContactBody& add_solid(const Body& body);
  // Returns the grids with their nodes from `node` on.
  std::vector<NodeGrid> grids_at(const Packed* node) const;
};

}  // namespace palp
