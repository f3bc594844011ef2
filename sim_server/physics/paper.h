// Method "paper": Eq. 2 and 3 term by term, with kernels of Mueller, Charypar & Gross 2003. Density by summation
// over all media, pressure P = c^2 (rho - rho0), clamped at zero; contact between any two bodies is the same pressure
// and viscosity. Rigid particles have no internal forces, so a body's own particles count in its density but do not
// push.
//
// Eq. 2   f_i = -V_i sum_j V_j (P_i + P_j)/2 gradW      half the gradient of P: a resting fluid shows twice rho g d
// Eq. 3   f_i = mu V_i sum_j V_j (v_j - v_i) lapW
//
// Density and Eq. 2 have the same kernel, poly6: the force is then nearly the gradient of an energy, half of what the
// equation of state would store. With the gradient of the spiky kernel beside a density by poly6, as Mueller has it, a
// fluid of little viscosity heats itself at any sub-step: a block that falls into a tray creates a third of what it
// turns over, where it now creates less than a hundredth.
#pragma once

#include "sim_server/physics/equation_of_state.h"
#include "sim_server/physics/rigid.h"

namespace palp {

// Sums up the density and moves every particle from the sorted copy to the state.
struct PaperDensity {
  ParticleView from, to;
  CellGrid grid;
  Mueller kernel;
  Medium medium;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = from.tag[i];
    if (tag_i.inactive()) {
      if (team.leader()) copy_particle(from, i, to, i);
      return;
    }
    const real m_i = from.mass[i];
    // Eq. 1 for the density, with the particle's own mass for every neighbour: media of different density do not smear
    real number = 0;
    for_neighbors(grid, from.xV, from.xV[i].xyz(), kernel.support, team,
                  [&](std::uint32_t, const Packed&, const Vec3&, real r2) { number += kernel.poly6(r2); });
    number = team.sum(number);
    if (!team.leader()) return;
    const real rho = m_i * number;
    copy_particle(from, i, to, i);
    to.vp[i].w = pressure_at(rho, medium.material[tag_i.material()].density, medium.sound_speed);
    to.xV[i].w = m_i / rho;
  }
};

// Returns the force of particle j on particle i by Eq. 2 and 3 [N].
PALP_HD inline Vec3 paper_pair_force(const Medium& medium, const Mueller& kernel, Tag tag_i, const Packed& xV_i,
                                     const Packed& vp_i, Tag tag_j, const Packed& xV_j, const Packed& vp_j,
                                     const Vec3& x_ij, real r2) {
  const real r = Eigen::numext::sqrt(r2), VV = xV_i.w * xV_j.w;
  const real P = acting_pressure(medium, vp_i.w) + acting_pressure(medium, vp_j.w);
  const real mu =
      real(0.5) * (medium.material[tag_i.material()].viscosity + medium.material[tag_j.material()].viscosity);
  return VV * (real(0.5) * P * kernel.poly6_F(r2) * x_ij - mu * kernel.laplacian(r) * (vp_i.xyz() - vp_j.xyz()));
}

// Computes the acceleration of fluids, and the force on each particle of the bodies whose wrench is asked for.
template <class Bonds>
struct PaperForce {
  ParticleView state;
  BodyViews bodies;  // null pointers without solids
  CellGrid grid;
  Mueller kernel;
  Medium medium;
  const Forcing* forcing;
  Packed* acceleration;
  Bonds bonds;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = state.tag[i];
    const BodyState* body = tag_i.is_fluid() ? nullptr : &bodies.body[tag_i.body()];
    if (body != nullptr && body->force_first == kNone) return;
    const Packed xV_i = state.xV[i], vp_i = state.vp[i];
    const auto solid_i = bonds.solid(state, i);
    Vec3 force(0, 0, 0);
    for_neighbors(grid, state.xV, xV_i.xyz(), kernel.support, team,
                  [&](std::uint32_t j, const Packed& xV_j, const Vec3& x_ij, real r2) {
                    const Tag tag_j = state.tag[j];
                    if (body != nullptr && tag_j.body() == tag_i.body()) return;
                    force +=
                        bonds.paper_share(tag_i, solid_i, tag_j, bonds.solid(state, j)) *
                        paper_pair_force(medium, kernel, tag_i, xV_i, vp_i, tag_j, xV_j, fetch(state.vp, j), x_ij, r2);
                  });
    force = team.sum(force);
    if (!team.leader()) return;
    if (body == nullptr)
      acceleration[i] = pack(force / state.mass[i] + forcing->gravity + forcing->body_force, 0);
    else
      bodies.force[body->force_first + state.id[i] - body->first] = pack(force, 0);
  }
};

}  // namespace palp
