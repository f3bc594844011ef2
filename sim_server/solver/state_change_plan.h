// The plan of changes of state: which bodies change, and their arrays at the start. Host only.
#pragma once

#include <string>
#include <vector>

#include "sim_server/physics/rigid_pieces.h"
#include "sim_server/solver/plan.h"

namespace palp {

// Fills in the plan's slots; first of all, because matter that changes state counts as a fluid everywhere else. Throws
// ConfigError: a wrench asked for, method "paper" without bonds.
void plan_slots(const Scene& scene, Plan& plan);

struct ChangeStore {
  std::vector<std::uint32_t> slot_of, group, shaped, force_of;
  std::vector<Tag> tag;
  std::vector<Packed> x, v, own, other;
  std::vector<real> solid, set, soft;
  std::vector<Quat> rotation;
  std::vector<Mat3> correction, projection;
  std::vector<std::uint32_t> bonds, bond;
  std::vector<std::uint32_t> piece;
  std::vector<Solidity> fraction;  // by particle

  // Bonds the particles that are solid at the start, without strain.
  ChangeStore(const Scene& scene, const Plan& plan);
};

// Returns Snapshot::body_id. piece: ChangeViews::piece.
std::vector<std::uint32_t> body_ids(const Scene& scene, const Plan& plan, const std::vector<std::uint32_t>& piece);

// Returns Snapshot::rigid. root: RigidViews::root.
std::vector<std::uint8_t> rigid_particles(const Scene& scene, const Plan& plan, const std::vector<std::uint32_t>& root);

}  // namespace palp
