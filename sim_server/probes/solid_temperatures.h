// The solids of a scene that bound heat by their geometry (scene_heat.h), as a mean over particles around a point
// counts them. Host, double precision.
#pragma once

#include <vector>

#include "sim_server/solver/contact_store.h"
#include "sim_server/solver/simulation.h"

namespace palp {

class SolidTemperatures {
 public:
  explicit SolidTemperatures(const Scene& scene);  // keeps a reference

  // Calls visit(body, share) for each of them that is within reach of x: the share that a plane at its distance would
  // have in the sum of Wendland's C2 kernel of radius `reach` around x. state_of(body): its state.
  template <class StateOf, class Visit>
  void near(const Eigen::Vector3d& x, double reach, StateOf&& state_of, Visit&& visit) const {
    for (std::size_t k = 0; k < store_.shaped.size(); ++k) {
      const std::uint32_t body = store_.shaped[k];
      if (!bounds_heat_[k]) continue;
      const double share = share_of_plane(distance(k, x, state_of(body)) / reach);
      if (share > 0) visit(body, share);
    }
  }

 private:
  // Returns the distance of a place from the solid of the k-th body that has one.
  double distance(std::size_t k, const Eigen::Vector3d& x, const RigidState& state) const;
  static double share_of_plane(double distance_over_reach);

  const Scene& scene_;
  ContactStore store_;
  std::vector<NodeGrid> grids_;
  std::vector<bool> bounds_heat_;  // by the order of those that have a distance field
};

}  // namespace palp
