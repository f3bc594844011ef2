// What leaves the domain, on a side from which gravity does not bring it back.
//
// A liquid particle past the margin is let go: from then on it is in no cell and in nobody's list, so it exerts nothing
// and receives nothing, and it stays where it is put. It keeps its index, its mass is counted as lost. What is solid,
// frozen matter included, would fall on until its speed or its place is past what numbers hold: out there it has no
// weight and comes to rest within kHaltTime, as in a thick air, whole and within reach of a hand. Where nothing pulls
// it flies on.
#pragma once

#include "sim_server/physics/cell_grid.h"
#include "sim_server/physics/particles.h"

namespace palp {

inline constexpr real kHaltTime = real(0.2);  // in which a solid's speed falls to 1/e [s]

// Whether x has left along this axis; pull: what drives it.
PALP_HD inline bool has_left(const CellGrid& grid, const Vec3& x, const Vec3& pull, int axis) {
  if (grid.periodic(axis)) return false;
  const real in = x[axis] - grid.origin[axis], length = static_cast<real>(grid.n[axis]) * grid.cell[axis];
  return (in < -grid.margin && !(pull[axis] > real(0))) || (in > length + grid.margin && !(pull[axis] < real(0)));
}

PALP_HD inline bool has_left(const CellGrid& grid, const Vec3& x, const Vec3& pull) {
  return has_left(grid, x, pull, 0) || has_left(grid, x, pull, 1) || has_left(grid, x, pull, 2);
}

// Where a particle is kept that has left: farther out by a margin. So far a jump makes the neighbours be listed anew.
PALP_HD inline Vec3 kept_place(const CellGrid& grid, Vec3 x, const Vec3& pull) {
  for (int a = 0; a < 3; ++a)
    if (has_left(grid, x, pull, a)) x[a] += x[a] < grid.origin[a] ? -grid.margin : grid.margin;
  return x;
}

// The cell to sort a particle into: past the last one once it has left.
PALP_HD inline std::uint32_t sort_cell(const CellGrid& grid, Tag tag, const Packed& x) {
  return tag.gone() ? grid.cells() : grid.index_of(x.xyz());
}

// What acts on a solid at x besides its forces: v' = kept (v + dt (f/m + pull)).
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
