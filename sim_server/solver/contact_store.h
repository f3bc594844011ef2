// The bodies' solids and the pairs that can touch, in the layout of the contact kernels. Host only.
#pragma once

#include <vector>

#include "sim_server/physics/rigid_contact.h"
#include "sim_server/scene/solid_layout.h"
#include "sim_server/solver/plan.h"

namespace palp {

struct ContactStore : SolidLayout {
  std::vector<ContactPair> pair;  // pairs of rigid and fixed bodies, then of soft parts
  std::uint32_t rigid_pairs = 0;
  bool single_pass = true;        // ContactViews::single_pass
  bool elastic_on_rigid = false;  // ContactViews::elastic_on_rigid
  std::vector<SoftPart> elastic_part, frozen_part;
  std::vector<std::uint32_t> shaped;  // the bodies that the shapes are of
  std::vector<SurfacePoint> point;
  std::vector<Round> round;
  std::vector<std::uint32_t> of_body, part;
  std::vector<std::uint32_t> held;  // PairWrenches::held; empty without such pairs
  std::uint32_t held_pairs = 0;
  std::size_t states = 0;          // of points of rigid pairs, then of soft parts
  std::size_t elastic_states = 0;  // those of elastic parts, the first of soft ones
  std::uint32_t first_soft = 0;    // ContactViews::first_soft

  ContactStore(const Scene& scene, const Plan& plan);

 private:
  using Parts = std::vector<std::vector<std::uint32_t>>;  // by body: its entries of part
  void add_rigid_pairs(const Scene& scene, const Plan& plan, Parts& parts);
  // Adds the parts of a soft body, whose particles begin at `first` in the order of its matter.
  void add_soft_parts(const Scene& scene, const Plan& plan, std::uint32_t body, std::uint32_t first,
                      std::vector<SoftPart>& list, Parts& parts);
  std::vector<std::uint32_t> shape_of_;  // per body, kNone
};

}  // namespace palp
