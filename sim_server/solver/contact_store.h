// The bodies' solids and the pairs that can touch, as the contact kernels want them. Host only.
#pragma once

#include <vector>

#include "sim_server/physics/contact.h"
#include "sim_server/scene/scene.h"
#include "sim_server/solver/plan.h"

namespace palp {

struct ContactStore {
  std::vector<ContactPair> pair;  // of rigid and fixed bodies, then of soft parts
  std::uint32_t rigid_pairs = 0;
  bool few = true;  // ContactViews::few
  std::vector<SoftPart> elastic_part, frozen_part;
  std::vector<ContactBody> shape;
  std::vector<Piece> piece;
  std::vector<NodeGrid> grid;  // without their nodes
  std::vector<Packed> node;    // of all grids, one after another
  std::vector<Packed> point;
  std::vector<std::uint32_t> of_body, part;
  std::vector<std::uint32_t> held;  // PairWrenches::held; empty without such pairs
  std::uint32_t held_pairs = 0;
  std::size_t states = 0;
  std::uint32_t first_frozen = 0;  // of the states

  ContactStore(const Scene& scene, const Plan& plan);
  // The grids with their nodes from `node` on.
  std::vector<NodeGrid> grids_at(const Packed* node) const;

 private:
  using Parts = std::vector<std::vector<std::uint32_t>>;  // of each body
  void add_rigid_pairs(const Scene& scene, const Plan& plan, Parts& parts);
  // Of a soft body, whose particles begin at `first` in the order of its matter.
  void add_soft_parts(const Scene& scene, const Plan& plan, std::uint32_t body, std::uint32_t first,
                      std::vector<SoftPart>& list, Parts& parts);
  std::vector<std::uint32_t> shape_of_;  // per body, kNone
};

// kappa and gamma of physics/contact.h.
struct BounceNumbers {
  double stiffness = 0, damping = 0;
};
// So that a ball bounces with this restitution, 0 to 1, on the mean over the moments within a sub-step at which it may
// arrive, and never with more than 1. Below about 0.1 it is as small as stable damping makes it. implicit: as a tool in
// a hand meets fixed bodies.
BounceNumbers bounce_numbers(double restitution, bool implicit);

// Of two bodies: static and kinetic friction as the geometric mean of the materials', restitution as the smaller one.
ContactLaw meet(const MaterialConfig& a, const MaterialConfig& b, bool implicit);

}  // namespace palp
