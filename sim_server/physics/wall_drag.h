// The viscous drag of solids that act by their geometry (walls.h), where viscosity is taken in stages
// (viscosity.h). Each fluid particle keeps the coefficients k_ib = 2 mu V shear of the bodies beside it [N s/m]; a
// stage's force on it is -k_ib min(l_i, l_b) (Y_i - Y_b), with Y_b the body's velocity at the nearest place on its
// surface, and the body receives the opposite there.
#pragma once

#include "sim_server/physics/viscosity.h"
#include "sim_server/physics/walls.h"

namespace palp {

// Measures the coefficients of each fluid particle.
struct MeasureWallDrag {
  ParticleView state;
  BodyViews bodies;
  WallViews walls;
  CellGrid grid;
  Medium medium;
  ViscosityViews viscosity;

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = state.tag[i];
    WallDrag drag = no_drag();
    if (tag.is_fluid() && !tag.inactive()) {
      const real scale = real(2) * medium.material[tag.material()].viscosity * state.xV[i].w;
      for (std::uint32_t k = 0; k < walls.by.bodies; ++k) {
        const NearBody b =
            known_body(walls, grid, medium, bodies.body[walls.body[k]], k, i, state.xV[i].xyz(), nullptr);
        if (b.near) drag.add(k, scale * b.wall.shear, b.foot);
      }
    }
    viscosity.drag[i] = drag;
  }
};

// Adds up what a stage's drag does to the bodies, over the particles of a part; one team a part. Before the first stage
// it adds up the coefficients instead (SumWallDrag).
struct WallDragReaction {
  ParticleView state;
  BodyViews bodies;
  WallViews walls;
  CellGrid grid;
  ViscosityViews viscosity;
  std::uint32_t count;
  StageNumbers numbers;

  template <class Team>
  PALP_HD void operator()(std::uint32_t part, Team team) const {
    const WallRange range = wall_range(walls, part, count);
    const Packed* from = viscosity.stage[numbers.from];
    for (std::uint32_t k = 0; k < walls.by.bodies; ++k) {
      const std::uint32_t index = walls.body[k];
      const BodyState& body = bodies.body[index];
      if (body.force_first == kNone) continue;
      Vec3 force(0, 0, 0), torque(0, 0, 0);
      for (std::uint32_t i = range.begin + team.lane(); i < range.end; i += team.size()) {
        const WallDrag& drag = viscosity.drag[i];
        const int at = drag.find(k);
        if (at == WallDrag::kMost) continue;
        const Packed Y_i = from[i], Y_b = stage_velocity(viscosity, body, index, numbers.from, drag.foot[at]);
        const Vec3 f = (drag.k[at] * min(Y_i.w, Y_b.w)) * (Y_i.xyz() - Y_b.xyz());
        force += f;
        torque += drag.foot[at].cross(f);
      }
      force = team.sum(force);
      torque = team.sum(torque);
      if (!team.leader()) continue;
      if (body.kind == BodyKind::rigid) {
        const ViscousBody& b = viscosity.body[index];
        torque += b.limit * viscosity.turning[part * walls.by.bodies + k].torque(b.w[numbers.from]);
      }
      viscosity.drag_wrench[part * walls.by.bodies + k] = {force, torque};
      WallWrench& total = walls.by.wrench[part * walls.by.bodies + k];
      total.force += numbers.share * force;
      total.torque += numbers.share * torque;
    }
  }
};

// Adds up the coefficients of a part's particles and their moments, for the bodies' limits, and what bodies feel that
// turn; one team a part.
struct SumWallDrag {
  ParticleView state;
  BodyViews bodies;
  WallViews walls;
  CellGrid grid;
  Medium medium;
  ViscosityViews viscosity;
  std::uint32_t count;

  template <class Team>
  PALP_HD void operator()(std::uint32_t part, Team team) const {
    const WallRange range = wall_range(walls, part, count);
    for (std::uint32_t k = 0; k < walls.by.bodies; ++k) {
      const BodyState& body = bodies.body[walls.body[k]];
      if (body.kind != BodyKind::rigid) continue;
      DragMoments sum = no_moments();
      TurningDrag turning = no_turning();
      for (std::uint32_t i = range.begin + team.lane(); i < range.end; i += team.size()) {
        const WallDrag& drag = viscosity.drag[i];
        const int at = drag.find(k);
        if (at == WallDrag::kMost) continue;
        const NearBody b = known_body(walls, grid, medium, body, k, i, state.xV[i].xyz(), nullptr);
        const real mu = medium.material[state.tag[i].material()].viscosity;
        sum.add(drag.k[at], drag.foot[at]);
        turning.add(real(2) * mu * state.xV[i].w * b.wall.slope, drag.foot[at]);
      }
      sum.sum = team.sum(sum.sum);
      sum.moment = team.sum(sum.moment);
      sum.squares = team.sum(sum.squares);
      sum.products = team.sum(sum.products);
      turning = {team.sum(turning.px), team.sum(turning.py), team.sum(turning.pz)};
      if (!team.leader()) continue;
      viscosity.drag_moments[part * walls.by.bodies + k] = sum;
      viscosity.turning[part * walls.by.bodies + k] = turning;
    }
  }
};

}  // namespace palp
