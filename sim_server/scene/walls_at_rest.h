// Solids as fluids beside them feel them by their geometry (physics/wall_share.h), where they are at the start. Host
// only.
#pragma once

#include <vector>

#include "sim_server/physics/wall_share.h"
#include "sim_server/scene/solid_shapes.h"

namespace palp {

// The solids as a place has them, world axes.
struct WallsHere {
  Eigen::Vector3d slope = Eigen::Vector3d::Zero();   // as in WallShare, of all of them [1/m]
  double share = 0;                                  // in sum V W
  double distance = 1e30;                            // of the nearest solid that is near, below 0 inside [m]
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // of its surface, outwards
};

class WallsAtRest {
 public:
  explicit WallsAtRest(const Scene& scene);  // keeps a reference

  bool none() const { return shapes_.shape.empty(); }
  // Returns what the solids are to a fluid particle at x. Those out of reach of its kernel count for nothing.
  WallsHere at(const Eigen::Vector3d& x) const;
  // Returns whether no thin wall stands between two places (physics/wall_sight.h).
  bool in_sight(const Eigen::Vector3d& x, const Eigen::Vector3d& y) const;
  bool some_thin() const { return some_thin_; }

 private:
  // Returns the way to x from the centre of mass of the k-th solid's body, in its axes.
  Vec3 from_center(std::size_t k, const Eigen::Vector3d& x) const;

  const Scene& scene_;
  SolidShapes shapes_;
  std::vector<NodeGrid> grids_;
  WallKernel kernel_;
  bool some_thin_ = false;
};

}  // namespace palp
