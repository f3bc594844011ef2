// Matter that leaves the domain, on a side from which gravity does not bring it back.
//
// A liquid particle past the margin becomes inactive: from then on it is in no cell and in no list, so it exerts
// nothing and receives nothing, and it stays where it is put. It keeps its index, its mass is counted as lost. Solids,
// frozen matter included, would fall on until their speed or place overflows: out there they have no weight and come to
// rest within kHaltTime, as in a thick air, whole and within reach of a hand. Where nothing pulls they fly on.
#pragma once

#include "sim_server/physics/cell_grid.h"
#include "sim_server/physics/particles.h"

namespace palp {

inline constexpr real kHaltTime = real(0.2);  // time in which a solid's speed falls to 1/e [s]

// Returns true when x has left along this axis; pull: the acceleration that drives it [m/s^2].
PALP_HD inline bool has_left(const CellGrid& grid, const Vec3& x, const Vec3& pull, int axis) {
  if (grid.periodic(axis)) return false;
  const real in = x[axis] - grid.origin[axis], length = static_cast<real>(grid.n[axis]) * grid.cell[axis];
  return (in < -grid.margin && !(pull[axis] > real(0))) || (in > length + grid.margin && !(pull[axis] < real(0)));
}

PALP_HD inline bool has_left(const CellGrid& grid, const Vec3& x, const Vec3& pull) {
  return has_left(grid, x, pull, 0) || has_left(grid, x, pull, 1) || has_left(grid, x, pull, 2);
}

// Returns the place of a particle that has left: farther out by a margin. A jump this far makes the neighbours be
// listed anew.
PALP_HD inline Vec3 inactive_position(const CellGrid& grid, Vec3 x, const Vec3& pull) {
  for (int a = 0; a < 3; ++a)
    if (has_left(grid, x, pull, a)) x[a] += x[a] < grid.origin[a] ? -grid.margin : grid.margin;
  return x;
}

// Returns the cell to sort a particle into; that of an inactive one is past the last cell.
PALP_HD inline std::uint32_t sort_cell(const CellGrid& grid, Tag tag, const Packed& x) {
  return tag.inactive() ? grid.cells() : grid.index_of(x.xyz());
}

// The acceleration of a solid besides its forces, and the share of its velocity that a sub-step keeps:
// v' = kept (v + dt (f/m + pull)).
struct Surroundings {
  Vec3 pull;  // [m/s^2]
  real kept;
};

PALP_HD inline Surroundings surroundings(const CellGrid& grid, const Forcing& forcing, const Vec3& x, real dt) {
  const Vec3 pull = forcing.gravity + forcing.body_force;
  if (pull.isZero(0) || !has_left(grid, x, pull)) return {pull, real(1)};
  return {Vec3(0, 0, 0), real(1) / (real(1) + dt / kHaltTime)};
}

}  // namespace palp
