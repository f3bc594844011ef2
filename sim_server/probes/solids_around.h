// The solids of a scene, as a mean over particles around a point counts them. Host, double precision.
#pragma once

#include <vector>

#include "sim_server/physics/distance.h"
#include "sim_server/solver/contact_store.h"
#include "sim_server/solver/simulation.h"

namespace palp {

class SolidsAround {
 public:
  explicit SolidsAround(const Scene& scene);  // keeps a reference

  // Calls visit(body, share) for each solid within reach of x that bounds heat by its geometry (scene_heat.h): the
  // share that a plane at its distance would have in the sum of Wendland's C2 kernel of radius `reach` around x.
  // state_of(body): its state.
  template <class StateOf, class Visit>
  void that_bound_heat(const Eigen::Vector3d& x, double reach, StateOf&& state_of, Visit&& visit) const {
    for (std::size_t k = 0; k < store_.shaped.size(); ++k) {
      const std::uint32_t body = store_.shaped[k];
      if (!bounds_heat_[k]) continue;
      const double share = share_of_plane(distance(k, from_center(k, x, state_of(body))).d / reach);
      if (share > 0) visit(body, share);
    }
  }

  // Returns the share of the kernel of fluids around x that the solids leave which act on fluids by their geometry, at
  // most 1: 1/2 on a plane, 1/4 in a right angle. No place is in two of them, so what they fill adds up.
  // support: the kernel's, H [m].
  template <class StateOf>
  double room(const Eigen::Vector3d& x, double support, StateOf&& state_of) const {
    double room = 1;
    if (!by_geometry_) return room;
    for (std::size_t k = 0; k < store_.shaped.size(); ++k)
      room -= share(k, from_center(k, x, state_of(store_.shaped[k])), support);
    return room;
  }
  // Returns whether a body is one of those.
  bool acts_by_geometry(const Body& body) const { return by_geometry_ && body.contact != nullptr; }

 private:
  // Returns the way to x from the centre of mass of the k-th body that has a distance field, in its axes.
  Eigen::Vector3d from_center(std::size_t k, const Eigen::Vector3d& x, const RigidState& state) const;
  // Returns the distance of its solid from there.
  Distance distance(std::size_t k, const Eigen::Vector3d& r) const;
  // Returns its share in the kernel around there.
  double share(std::size_t k, const Eigen::Vector3d& r, double support) const;
  static double share_of_plane(double distance_over_reach);

  SolidsAround(const Scene& scene, const Plan& plan);

  const Scene& scene_;
  ContactStore store_;
  std::vector<NodeGrid> grids_;
  bool by_geometry_;
  std::vector<bool> bounds_heat_;  // by the order of those that have a distance field
};

}  // namespace palp
