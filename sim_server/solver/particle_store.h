// The particles and bodies of a scene in the kernels' layout, on the host: what a back end uploads at reset and
// downloads for a snapshot.
#pragma once

#include <vector>

#include "sim_server/physics/cell_grid.h"
#include "sim_server/physics/cohesion.h"
#include "sim_server/physics/heat.h"
#include "sim_server/solver/plan.h"
#include "sim_server/solver/simulation.h"

namespace palp {

// Returns a place as the kernels have it, rounded to real.
Eigen::Vector3d rounded(const Eigen::Vector3d& place);

struct ParticleStore {
  std::vector<Packed> xV, vp;
  std::vector<real> mass;
  std::vector<Tag> tag;
  std::vector<std::uint32_t> id;
  std::vector<real> temperature, enthalpy;
  std::vector<BodyState> bodies;
  std::vector<Packed> local;  // BodyViews::local

  // The initial state: fluids at rest get the hydrostatic pressure of the fluid above them when gravity acts from the
  // start.
  ParticleStore(const Scene& scene, const Plan& plan);
  // Writes downloaded arrays in the scene's order.
  void scatter(const Medium& medium, Snapshot& out) const;
  // Writes the heat that each particle took up since the start, when it had the enthalpies `start`, and its liquid
  // fraction, in the scene's order.
  void scatter_heat(const std::vector<real>& start, const HeatMedium& medium, Snapshot& out) const;
};

CellGrid make_grid(const Scene& scene, const Plan& plan);

}  // namespace palp
