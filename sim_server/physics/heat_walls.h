// Heat between particles and solids that act by their geometry (walls.h): those that hold their temperatures, and those
// that do not conduct.
//
// A solid that holds T_w is a perfect conductor, so that T_w holds at its surface, and the particle's temperature goes
// on into it in a straight line: T_w + (T_w - T_i) b / d at a depth b behind the surface, d being the particle's
// distance. At s from the particle that is T_i + (T_w - T_i) |s.n| / d, and the sum over a lattice in the solid, of 2
// k_i V_j F (T_j - T_i) as within one medium, becomes 2 k_i (T_w - T_i) int F |s.n| ds / d, the integral of
// WallShare::shear. So a linear profile up to a plane is exact on a lattice, and the flux with it. A solid that does
// not conduct gives nothing, as its particles would.
//
// Both fill their share of a particle's neighbourhood, which is no free surface there. Behind a wall all is wall,
// however thin: what lies on its other side is not felt.
#pragma once

#include "sim_server/physics/heat.h"
#include "sim_server/physics/walls.h"

namespace palp {

// The solids with a distance field, and the temperatures of those that hold them.
struct HeatWallViews {
  WallViews walls;
  const real* temperature = nullptr;  // by body [K]
};

// Measures what the solids are to the particles that conduct, where they lie now.
struct MeasureHeatWalls {
  ParticleView state;
  const BodyState* bodies;
  HeatWallViews solids;
  CellGrid grid;
  Medium medium;
  HeatViews heat;

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = state.tag[i];
    HeatWall wall = no_heat_wall();
    if (heat.role[tag.body()] == HeatRole::conducts && !tag.inactive()) {
      for (std::uint32_t k = 0; k < solids.walls.by.bodies; ++k) {
        const std::uint32_t body = solids.walls.body[k];
        if (heat.role[body] < HeatRole::held_wall) continue;
        const NearBody b = near_body(solids.walls, grid, medium, bodies[body], k, state.xV[i].xyz(), nullptr);
        if (!b.near) continue;
        wall.share += b.wall.share;
        if (heat.role[body] != HeatRole::held_wall || !(b.wall.shear > real(0))) continue;
        wall.shear += b.wall.shear;
        wall.temperature += b.wall.shear / wall.shear * (solids.temperature[body] - wall.temperature);
      }
    }
    heat.wall[i] = wall;
  }
};

}  // namespace palp
