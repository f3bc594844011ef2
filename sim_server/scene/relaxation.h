// Points that push each other apart until they fill the space between fixed ones and walls evenly.
#pragma once

#include <functional>
#include <vector>

#include "sim_server/geometry/point_grid.h"
#include "sim_server/scene/walls_at_rest.h"
#include "sim_server/threads/thread_team.h"

namespace palp {

// Moves points down the gradient of sum V W, walls' share included, until it vanishes or is small, and shares the space
// out among them.
struct Relaxation {
  PeriodicBox box;
  double spacing = 0;  // [m]
  double support = 0;  // of the fluids' kernel [m]
  const WallsAtRest& walls;
  std::vector<Eigen::Vector3d> place;  // of all points [m]
  std::vector<double> volume;          // of all points, over spacing^3
  std::vector<std::uint32_t> moving;   // indices of those that move
  std::vector<Eigen::Vector3f> held;   // of each of these: a direction, unit, along which it does not move; or zero
  // Called with the share of the most work that there may be that is done.
  std::function<void(double)> progress;
};

// Relaxes the places and the volumes (V = V0 / sum V W) of the moving points. The same bits whatever the number of
// threads.
void relax(Relaxation& points, ThreadTeam& team);

// Returns sum W dx^3 over the neighbourhood of a particle of a whole cubic lattice, itself included.
double lattice_sum(const FluidKernelOf<double>& kernel, double spacing);

}  // namespace palp
