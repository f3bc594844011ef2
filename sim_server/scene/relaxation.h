// Points that push each other apart until they fill the space between fixed ones evenly.
#pragma once

#include <functional>
#include <vector>

#include "sim_server/geometry/point_grid.h"
#include "sim_server/threads/thread_team.h"

namespace palp {

struct FreePlace {
  Eigen::Vector3d place;  // [m]
  double clear = 0;       // around it as far as this all is free [m]
};

// Moves points until sum V gradW vanishes or is small, and shares the space out among them.
struct Relaxation {
  PeriodicBox box;
  double spacing = 0;                  // [m]
  std::vector<Eigen::Vector3d> place;  // of all points [m]
  std::vector<double> volume;          // of all points, over spacing^3
  std::vector<std::uint32_t> moving;   // indices of those that move
  // Returns the nearest place that solids leave a point, as far past the ends of periodic axes as it is; empty: all
  // space is free. Any thread may call it.
  std::function<FreePlace(const Eigen::Vector3d& place)> hold;
  // Called with the share of the most work that there may be that is done.
  std::function<void(double)> progress;
};

// Relaxes the places and then the volumes of the moving points (V = V0 / sum V W). The same bits whatever the number of
// threads.
void relax(Relaxation& points, ThreadTeam& team);

}  // namespace palp
