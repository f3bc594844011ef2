// Solids as fluids feel them (Adami, Hu & Adams 2012): a solid particle shows the pressure and velocity extrapolated
// from the fluid around it, and receives the opposite of every force that it exerts.
//
// p_w = sum_f (p_f + rho_f g.(x_w - x_f)) W / sum W,   v_w = 2 v_wall - sum_f v_f W / sum W
// The wall's own acceleration, which Adami et al. subtract from g, is left out: with a body lighter than the fluid it
// would be explicit added mass, which is unstable.
#pragma once

#include "sim_server/physics/fluid.h"

namespace palp {

// Extrapolates pressure and velocity of the fluid to each particle of solids.
template <class Bonds>
struct ExtrapolateToWalls {
  ParticleView state;
  CellGrid grid;
  FluidKernel kernel;
  Medium medium;
  const Forcing* forcing;
  Packed* wall;  // out: velocity, pressure; solids only
  Bonds bonds;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = state.tag[i];
    if (tag_i.is_fluid() || tag_i.by_geometry()) return;
    const auto solid_i = bonds.solid(state, i);
    const Vec3 g = forcing->level_gravity;
    real p = 0, weight = 0;
    Vec3 v(0, 0, 0);
    for_neighbors(grid, state.xV, state.xV[i].xyz(), kernel.support, team,
                  [&](std::uint32_t j, const Packed&, const Vec3& x_ij, real r2) {
                    const Tag tag_j = state.tag[j];
                    if (!tag_j.is_fluid()) return;
                    const Packed vp_j = fetch(state.vp, j);
                    const real W =
                        kernel.W(Eigen::numext::sqrt(r2)) * bonds.share(tag_i, solid_i, tag_j, bonds.solid(state, j));
                    const Material& fluid = medium.material[tag_j.material()];
                    const real rho_j = density_at(vp_j.w, fluid.density, fluid.sound_speed);
                    p += W * (acting_pressure(medium, vp_j.w) + rho_j * g.dot(x_ij));
                    v += W * vp_j.xyz();
                    weight += W;
                  });
    p = team.sum(p);
    v = team.sum(v);
    weight = team.sum(weight);
    if (!team.leader()) return;
    const Vec3 v_wall = state.vp[i].xyz();
    wall[i] =
        weight > real(0) ? pack(real(2) * v_wall - v / weight, acting_pressure(medium, p / weight)) : pack(v_wall, 0);
  }
};

}  // namespace palp
