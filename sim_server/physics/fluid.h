// Weakly compressible fluid, method "accurate": the density is integrated by continuity with density diffusion, the
// momentum equation is symmetric in the pair, volumes and not masses weigh, so that media of different density meet.
//
// symbol    meaning                                    unit      source
// F         -W'(r)/r, gradW_ij = -F x_ij               1/m^5     smoothing.h
// drho/dt   rho_i sum V_j v_ij.gradW + delta h c D_i   kg/m^3/s  continuity; Molteni & Colagrossi 2009, with the
//                                                                hydrostatic part taken out: Fourtakas et al. 2019
// f^p       -V_i V_j (p_i + p_j) gradW                 N         pair form of grad p; antisymmetric and central
// f^v       -V_i V_j 2 mu F v_ij                       N         Morris, Fox & Zhu 1997: isotropic on a lattice
// f^a       alpha c h rho V_i V_j (v.x)/(r^2) gradW    N         Monaghan & Gingold 1983; central
#pragma once

#include "sim_server/physics/bonded.h"
#include "sim_server/physics/cell_grid.h"
#include "sim_server/physics/particles.h"
#include "sim_server/physics/smoothing.h"

namespace palp {

// Advances the density of fluid particles by one sub-step and moves every particle from the sorted copy to the state.
template <class Bonds>
struct AdvanceDensity {
  ParticleView from, to;
  CellGrid grid;
  WendlandC2 kernel;
  Medium medium;
  const Forcing* forcing;
  Bonds bonds;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = from.tag[i];
    if (!tag_i.is_fluid()) {
      if (team.leader()) copy_particle(from, i, to, i);
      return;
    }
    const Packed xV_i = from.xV[i], vp_i = from.vp[i];
    const Vec3 x_i = xV_i.xyz(), v_i = vp_i.xyz();
    const real c2 = medium.sound_speed * medium.sound_speed;
    const real rho0 = medium.material[tag_i.material()].density;
    const Vec3 hydrostatic = forcing->level_gravity * rho0;  // gradient of p at rest
    const auto solid_i = bonds.solid(from, i);
    real divergence = 0, laplacian = 0;
    for_neighbors(
        grid, from.xV, x_i, kernel.support, team, [&](std::uint32_t j, const Packed& xV_j, const Vec3& x_ij, real r2) {
          const Packed vp_j = fetch(from.vp + j);
          const Tag tag_j = medium.uniform ? tag_i : from.tag[j];
          const real VF =
              xV_j.w * kernel.F(Eigen::numext::sqrt(r2)) * bonds.share(tag_i, solid_i, tag_j, bonds.solid(from, j));
          // a fixed wall's velocity is that of its surface along itself: it drags, but does not squeeze
          const Vec3 v_j = tag_j.kind() == Kind::fixed ? Vec3(0, 0, 0) : vp_j.xyz();
          divergence += VF * (v_i - v_j).dot(x_ij);
          if (tag_j.is_fluid() && tag_j.material() == tag_i.material())
            laplacian += VF * (vp_j.w - vp_i.w + hydrostatic.dot(x_ij));
        });
    divergence = team.sum(divergence);
    laplacian = team.sum(laplacian);
    if (!team.leader()) return;
    // v_ij.gradW = -F v_ij.x_ij, so drho/dt = -rho * divergence; dp = c^2 drho
    const real rho = rho0 + vp_i.w / c2;
    const real diffusion = medium.diffusion * kernel.support * medium.sound_speed;  // delta 2 h c, h = H/2
    const real p = vp_i.w + medium.dt * (diffusion * laplacian - c2 * rho * divergence);
    copy_particle(from, i, to, i);
    to.vp[i].w = p;
    to.xV[i].w = from.mass[i] / (rho0 + p / c2);
  }
};

// What the artificial viscosity takes off the pressure between two particles that part, and adds when they approach.
PALP_HD inline real artificial_pressure(const Medium& medium, const WendlandC2& kernel, real rho, const Vec3& v_ij,
                                        const Vec3& x_ij, real r2) {
  const real h = real(0.5) * kernel.support;
  return medium.artificial * medium.sound_speed * h * rho * v_ij.dot(x_ij) / (r2 + real(0.01) * h * h);
}

// Force of fluid particle j on fluid particle i.
PALP_HD inline Vec3 fluid_pair_force(const Medium& medium, const WendlandC2& kernel, const Material& material_i,
                                     Tag tag_i, const Packed& xV_i, const Packed& vp_i, Tag tag_j, real V_j,
                                     const Packed& vp_j, const Vec3& x_ij, real r2) {
  const real VVF = xV_i.w * V_j * kernel.F(Eigen::numext::sqrt(r2));
  const Vec3 v_ij = vp_i.xyz() - vp_j.xyz();
  real rho = material_i.density, mu = material_i.viscosity;
  if (tag_j.material() != tag_i.material()) {
    const Material& b = medium.material[tag_j.material()];
    const real mu_sum = mu + b.viscosity;
    rho = real(0.5) * (rho + b.density);
    mu = mu_sum > real(0) ? real(2) * mu * b.viscosity / mu_sum : real(0);
  }
  const real along = acting_pressure(medium, vp_i.w) + acting_pressure(medium, vp_j.w) -
                     artificial_pressure(medium, kernel, rho, v_ij, x_ij, r2);
  return VVF * (along * x_ij - real(2) * mu * v_ij);
}

// Force of solid particle j, moving with v_j, on fluid particle i. wall: the pressure that the solid shows to the fluid
// (w) and the velocity that makes the mean of fluid and wall the wall's own at its surface (boundary.h). The artificial
// viscosity acts here too: without it the extrapolated wall pressure can feed sound waves.
PALP_HD inline Vec3 wall_pair_force(const Medium& medium, const WendlandC2& kernel, Tag tag_i, const Packed& xV_i,
                                    const Packed& vp_i, real V_j, const Vec3& v_j, const Packed& wall_j,
                                    const Vec3& x_ij, real r2) {
  const real VVF = xV_i.w * V_j * kernel.F(Eigen::numext::sqrt(r2));
  const Material& fluid = medium.material[tag_i.material()];
  const real along = acting_pressure(medium, vp_i.w) + wall_j.w -
                     artificial_pressure(medium, kernel, fluid.density, vp_i.xyz() - v_j, x_ij, r2);
  return VVF * (along * x_ij - real(2) * fluid.viscosity * (vp_i.xyz() - wall_j.xyz()));
}

// Acceleration of fluid particles [m/s^2], into acceleration[i].
template <class Bonds>
struct FluidForce {
  ParticleView state;
  const Packed* wall;  // null without solids
  CellGrid grid;
  WendlandC2 kernel;
  Medium medium;
  const Forcing* forcing;
  Packed* acceleration;
  Bonds bonds;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = state.tag[i];
    if (!tag_i.is_fluid()) return;
    const Packed xV_i = state.xV[i], vp_i = state.vp[i];
    const Material material_i = medium.material[tag_i.material()];
    const auto solid_i = bonds.solid(state, i);
    Vec3 force(0, 0, 0);
    for_neighbors(grid, state.xV, xV_i.xyz(), kernel.support, team,
                  [&](std::uint32_t j, const Packed& xV_j, const Vec3& x_ij, real r2) {
                    const Packed vp_j = fetch(state.vp + j);
                    const Tag tag_j = medium.uniform ? tag_i : state.tag[j];
                    const real share = bonds.share(tag_i, solid_i, tag_j, bonds.solid(state, j));
                    if (tag_j.is_fluid())
                      force += share * fluid_pair_force(medium, kernel, material_i, tag_i, xV_i, vp_i, tag_j, xV_j.w,
                                                        vp_j, x_ij, r2);
                    else
                      force += share * wall_pair_force(medium, kernel, tag_i, xV_i, vp_i, xV_j.w, vp_j.xyz(),
                                                       fetch(wall + j), x_ij, r2);
                  });
    force = team.sum(force);
    if (team.leader()) acceleration[i] = pack(force / state.mass[i] + forcing->gravity + forcing->body_force, 0);
  }
};

}  // namespace palp
