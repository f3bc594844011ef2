// Weakly compressible fluid, method "accurate": the density is integrated by continuity with density diffusion, the
// momentum equation is symmetric in the pair, volumes and not masses weigh, so that media of different density meet.
//
// symbol    meaning                                    unit      source
// F         -W'(r)/r, gradW_ij = -F x_ij               1/m^5     smoothing.h
// drho/dt   rho_i sum V_j v_ij.gradW + delta h c D_i   kg/m^3/s  continuity; Molteni & Colagrossi 2009, with the
//                                                                hydrostatic part taken out: Fourtakas et al. 2019;
//                                                                no sub-step passes the mean of the neighbours
//           + k rho e (C/C0 - 1)                                 ties volume to places, k = kVolumeTie
//           - (rho - rho0)+ c/dx (1 - C'/(kDropCover C0))+       a drop by itself: kept_by_drop()
// C         sum V_j W, C0 that of a lattice            -
// C'        C without the particle's own V W           -
// e         sum V_j F |v_ij.x_ij|                      1/s       the rate of strain
// f^p       -V_i V_j (p_i + p_j) gradW                 N         pair form of grad p; antisymmetric and central
// f^v       -V_i V_j 2 mu F v_ij                       N         Morris, Fox & Zhu 1997: isotropic on a lattice
// f^a       alpha c h rho V_i V_j (v.x)/(r^2) gradW    N         Monaghan & Gingold 1983; central
//
// V = m / rho(acting pressure): a liquid that has come apart does not expand, though its density goes on falling, which
// tells when it touches again. With m / rho the particles of a thin drop had five times their volume, and viscosity
// between them, twenty times too large for the sub-step, threw them out of a cup.
//
// Where two media meet, with the impedances Z = rho0 c, the pressure between them is (Z_j p_i + Z_i p_j)/(Z_i + Z_j)
// and the velocity (Z_i v_i + Z_j v_j)/(Z_i + Z_j), as when a wave comes to an interface (Hu & Adams 2006 have rho for
// Z). So p_i + p_j and v_ij get the shares below, which are adjoint to each other and keep momentum and energy, and a
// light particle feels its own medium's stiffness, not that of the heavy one, which would throw it about.
#pragma once

#include "sim_server/physics/bonded.h"
#include "sim_server/physics/cell_grid.h"
#include "sim_server/physics/equation_of_state.h"
#include "sim_server/physics/particles.h"
#include "sim_server/physics/smoothing.h"

namespace palp {

// The relative speed of two particles, over c, below which density does not diffuse between them. Diffusion takes the
// pressure away that holds particles in their places, and a fluid that should rest creeps for ever: a box of 6 x 6
// x 4 particles went round and round by a spacing in 20 s.
inline constexpr real kDiffusionThreshold = real(0.0003);
// Where both particles are beside solids that act by their geometry, which leave a lattice in its place, it always
// diffuses, and by this factor more: sound there is damped by nothing else. The force on a ball of 1.25 spacings, half
// under water, then comes to rest within 1.2 mN rms from 6 to 16 s (3.9 with a factor of 1; 7.6 if density diffuses
// at rest between all particles).
inline constexpr real kWallDiffusion = real(2);

// The least and the largest density over that at rest. Far past what a run is stopped for, so that what has diverged
// stays finite until the haptic step ends and health tells of it.
inline constexpr real kLeastDensity = real(0.1), kLargestDensity = real(10);

PALP_HD inline real impedance(const Material& m) { return m.density * m.sound_speed; }

// Returns 2 Z_j / (Z_i + Z_j): the weight of v_ij in the density of i, and of p_i in the pressure between the two.
PALP_HD inline real impedance_weight(const Medium& medium, Tag tag_i, Tag tag_j) {
  const real Z_i = impedance(medium.material[tag_i.material()]), Z_j = impedance(medium.material[tag_j.material()]);
  return real(2) * Z_j / (Z_i + Z_j);
}

// Policies that say what neighbours there are, and whether two fluid particles are of different materials. What a scene
// does not hold is not asked for: that takes a third off the passes of a fluid alone.
struct ManyFluids {
  PALP_HD static Tag tag_of(const ParticleView& particles, std::uint32_t j, Tag) { return particles.tag[j]; }
  PALP_HD static bool is_fluid(Tag tag) { return tag.is_fluid(); }
  PALP_HD static bool differ(Tag tag_i, Tag tag_j) { return tag_i.material() != tag_j.material(); }
  // Returns whether particle j is of fluid particle i's kind and material.
  PALP_HD static bool alike(const ParticleView& particles, std::uint32_t j, Tag tag_i) {
    const Tag tag_j = particles.tag[j];
    return tag_j.is_fluid() && tag_j.material() == tag_i.material();
  }
};
struct OneFluid : ManyFluids {
  PALP_HD static bool differ(Tag, Tag) { return false; }
};
// All particles are of one fluid (Medium::uniform).
struct LoneFluid : OneFluid {
  PALP_HD static Tag tag_of(const ParticleView&, std::uint32_t, Tag tag_i) { return tag_i; }
  PALP_HD static bool is_fluid(Tag) { return true; }
  PALP_HD static bool alike(const ParticleView&, std::uint32_t, Tag) { return true; }
};

// How fast volume goes back to what the places of particles say, for each unit of strain. The density is integrated, so
// that its errors add up: a tray stirred for three minutes rose by 11 % (spacing 20 mm, potential energy), ever faster.
// With 0.03 it ended 1.2 % up, with 0.1 0.4 %, with 0.3 and 1 0.1 %; more makes pressure of the noise of C. With strain
// as the clock nothing is pulled at rest, where a lattice that is not quite even would creep for ever.
inline constexpr real kVolumeTie = real(0.1);
// |grad C| H of a particle that counts as one of a surface, C = sum V W: 1 to 1.3 on the face of a lattice, 0.2 at most
// in the row beneath.
inline constexpr real kSurfaceSlope = real(0.5);
// The largest |C/C0 - 1| that can be drift; more is a spray or a film, whose neighbourhood is not full.
inline constexpr real kLargestDrift = real(0.2);

// Returns by how much closer together particles lie than their volumes say, relative to a lattice [-]; less towards
// surfaces, where neighbours are missing, and 0 on them. cover: C, slope: -grad C [1/m].
PALP_HD inline real volume_drift(const Medium& medium, real cover, const Vec3& slope) {
  const real drift = cover / medium.cover - real(1);
  if (Eigen::numext::abs(drift) > kLargestDrift) return real(0);
  const real edge = medium.kernel.support / kSurfaceSlope, inside = real(1) - edge * edge * slope.squaredNorm();
  return inside > real(0) ? inside * drift : real(0);
}

// Below this share of C0 from others, sum over j != i of V_j W, a particle is a drop of its own, the more the less it
// is; a single neighbour at a spacing gives 0.07, one at a spacing and a half 0.02.
inline constexpr real kDropCover = real(0.05);

// Returns the share of a pressure that a particle keeps in a sub-step. Sound lets the pressure of a drop out through
// its surface within dx / c. A particle without neighbours knows of none: it kept what a wall that it fell on had given
// it, and so bounced off it without an end, denser each time. What it lacks it keeps lacking, as that tells when it
// touches others again. others: sum over j != i of V_j W.
PALP_HD inline real kept_by_drop(const Medium& medium, real p, real others, real c) {
  const real alone = real(1) - others / (kDropCover * medium.cover);
  if (!(p > real(0)) || !(alone > real(0))) return real(1);
  return real(1) / (real(1) + alone * medium.dt * c / medium.spacing);
}

// Advances the density of fluid particles by one sub-step and copies what changes of every particle from the sorted
// copy to the state, to which sorting has copied the rest.
template <class Fluids, class Bonds, class Kernel>
struct AdvanceDensity {
  ParticleView from, to;
  CellGrid grid;
  Kernel kernel;
  Medium medium;
  const Forcing* forcing;
  const Packed* wall_slope;  // of solids with a distance field (walls.h); null without any
  const real* wall_rate;
  Bonds bonds;
  Packed* shift_sums;  // by particle, as of shift_of(); null where none is shifted

  // The sums over a particle's neighbours. divergence: of the velocity [1/s]; laplacian: D_i [Pa/m^2]; diffusing: the
  // sum of its weights [1/m^2]; slope: -grad C.
  template <class S>
  struct Sums {
    S divergence = 0, laplacian = 0, diffusing = 0, cover = 0, strain = 0;
    Vec3Of<S> slope{0, 0, 0};
  };

  // kBesideWall: a solid with a distance field is in the particle's reach. pairs: by_lanes().
  template <bool kBesideWall, class Pairs>
  PALP_HD Sums<real> sum_neighbors(std::uint32_t i, Pairs pairs) const {
    using S = typename Pairs::Real;
    const Tag tag_i = from.tag[i];
    const auto solid_i = bonds.solid(from, i);
    const Packed vp_i = from.vp[i];
    const Vec3 x_i = from.xV[i].xyz();
    const Vec3Of<S> v_i = vp_i.xyz().template cast<S>();
    const Material& fluid = medium.material[tag_i.material()];
    const real threshold = kDiffusionThreshold * fluid.sound_speed * medium.spacing;
    const S inv_threshold2 = real(1) / (threshold * threshold);
    // gradient of p at rest
    const Vec3Of<S> hydrostatic = Vec3(forcing->level_gravity * fluid.density).template cast<S>();
    Sums<S> sums;
    for_neighbors(grid, from.xV, x_i, kernel.support, pairs,
                  [&](const auto& j, const PackedOf<S>& xV_j, const Vec3Of<S>& x_ij, S r2) PALP_INLINE {
                    const PackedOf<S> vp_j = fetch<S>(from.vp, j);
                    const std::uint32_t first = first_of(j);
                    const Tag tag_j = Fluids::tag_of(from, first, tag_i);
                    const bool fluid_j = Fluids::is_fluid(tag_j);
                    if (!fluid_j && tag_j.by_geometry()) return;
                    const S r = Eigen::numext::sqrt(r2), whole_VF = xV_j.w * kernel.F(r);
                    const S VF = whole_VF * bonds.share(tag_i, solid_i, tag_j, bonds.solid(from, first));
                    // a fixed wall's velocity is that of its surface along itself: it drags, but does not squeeze
                    const bool fixed_j = !fluid_j && tag_j.kind() == BodyKind::fixed;
                    const Vec3Of<S> v_j = fixed_j ? Vec3Of<S>(0, 0, 0) : vp_j.xyz();
                    const bool differ = Fluids::differ(tag_i, tag_j);
                    const real weight = differ && fluid_j ? impedance_weight(medium, tag_i, tag_j) : real(1);
                    const S apart = (v_i - v_j).dot(x_ij);
                    sums.divergence += weight * VF * apart;
                    sums.cover += xV_j.w * kernel.W(r);
                    sums.slope += whole_VF * x_ij;
                    sums.strain += whole_VF * Eigen::numext::abs(apart);
                    if (!fluid_j || differ) return;
                    S share = min(S(1), S(inv_threshold2 * apart * apart));
                    if constexpr (kBesideWall)
                      share = select(fetch_w<S>(wall_slope, j) > S(0), S(kWallDiffusion), share);
                    sums.laplacian += VF * share * (vp_j.w - vp_i.w + hydrostatic.dot(x_ij));
                    sums.diffusing += VF * share;
                  });
    return {pairs.sum(sums.divergence), pairs.sum(sums.laplacian), pairs.sum(sums.diffusing),
            pairs.sum(sums.cover),      pairs.sum(sums.strain),    pairs.sum(sums.slope)};
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = from.tag[i];
    if (!tag_i.is_fluid() || tag_i.inactive()) {
      if (team.leader()) copy_changing(from, i, to, i);
      return;
    }
    const bool beside_wall = wall_slope != nullptr && wall_slope[i].w > real(0);
    const auto alike = [&](std::uint32_t j) { return Fluids::alike(from, j, tag_i); };
    Sums<real> sums = by_lanes(team, bonds.leaves_all(bonds.solid(from, i)), alike, [&](auto pairs) {
      return beside_wall ? sum_neighbors<true>(i, pairs) : sum_neighbors<false>(i, pairs);
    });
    if (!team.leader()) return;
    const Packed vp_i = from.vp[i];
    const Material& fluid = medium.material[tag_i.material()];
    const real others = sums.cover - from.xV[i].w * kernel.W(real(0));
    if (wall_slope != nullptr) {
      const Packed wall = wall_slope[i];
      sums.slope += wall.xyz();
      sums.cover += wall.w;
      sums.divergence += wall_rate[i];
      sums.strain += Eigen::numext::abs(wall_rate[i]);
    }
    // v_ij.gradW = -F v_ij.x_ij, so drho/dt = -rho * divergence; dp = c^2 drho
    const real c = fluid.sound_speed, c2 = c * c, rho0 = fluid.density, rho = density_at(vp_i.w, rho0, c);
    real diffusion = medium.diffusion * kernel.support * c;  // delta 2 h c, h = H/2
    // Where particles crowd without a pressure, in a torn film that runs up a wall, a sub-step would take the density
    // past the mean of its neighbours', further each time, until its pressure threw the particle off at a third of c.
    const real passed = medium.dt * diffusion * sums.diffusing;
    if (passed > real(1)) diffusion /= passed;
    const real regained = kVolumeTie * sums.strain * volume_drift(medium, sums.cover, sums.slope);
    const real next = vp_i.w + medium.dt * (diffusion * sums.laplacian - c2 * rho * (sums.divergence - regained));
    const real least = pressure_at(kLeastDensity * rho0, rho0, c), most = pressure_at(kLargestDensity * rho0, rho0, c);
    // what is not a number stays so
    const real p = kept_by_drop(medium, next, others, c) * (next < least ? least : min(most, next));
    copy_changing(from, i, to, i);
    to.vp[i].w = p;
    to.xV[i].w = from.mass[i] / density_at(acting_pressure(medium, p), rho0, c);
    if (shift_sums != nullptr) shift_sums[i] = pack(sums.slope, sums.strain);
  }
};

// Returns the pressure that the artificial viscosity takes off between two particles that part; it is negative, which
// adds pressure, when they approach. Nothing is computed for fluids without artificial viscosity.
template <class S>
PALP_HD inline S artificial_pressure(const Medium& medium, real c, real rho, const Vec3Of<S>& v_ij,
                                     const Vec3Of<S>& x_ij, S r2) {
  if (!(medium.artificial > real(0))) return S(real(0));
  const real h = real(0.5) * medium.kernel.support;
  return medium.artificial * c * h * rho * v_ij.dot(x_ij) / (r2 + real(0.01) * h * h);
}

// Returns the force of fluid particle j on fluid particle i [N].
template <class Fluids, class Kernel, class S>
PALP_HD inline Vec3Of<S> fluid_pair_force(const Medium& medium, const Kernel& kernel, const Material& material_i,
                                          Tag tag_i, const Packed& xV_i, const Packed& vp_i, Tag tag_j, S V_j,
                                          const PackedOf<S>& vp_j, const Vec3Of<S>& x_ij, S r2) {
  const S VVF = xV_i.w * V_j * kernel.F(S(Eigen::numext::sqrt(r2)));
  const Vec3Of<S> v_ij = vp_i.xyz().template cast<S>() - vp_j.xyz();
  real c = material_i.sound_speed, rho = material_i.density, mu = material_i.viscosity;
  real p_i = acting_pressure(medium, vp_i.w);
  S p_j = acting_pressure(medium, vp_j.w);
  if (Fluids::differ(tag_i, tag_j)) {
    const Material& b = medium.material[tag_j.material()];
    const real mu_sum = mu + b.viscosity, Z_i = impedance(material_i), Z_j = impedance(b), Z = Z_i + Z_j;
    p_i *= real(2) * Z_j / Z;
    p_j *= real(2) * Z_i / Z;
    // the harmonic mean of Z, in which the smaller one counts most, as that of mu
    c = real(1);
    rho = real(2) * Z_i * Z_j / Z;
    mu = mu_sum > real(0) ? real(2) * mu * b.viscosity / mu_sum : real(0);
  }
  const S along = p_i + p_j - artificial_pressure(medium, c, rho, v_ij, x_ij, r2);
  return VVF * (along * x_ij - S(real(2) * mu) * v_ij);
}

// Returns a pressure that keeps a fluid particle out of the gaps between the particles of a solid that has no distance
// field, whatever its own pressure [Pa]. A fluid that fills its space keeps a larger distance.
template <class S>
PALP_HD inline S guarding_pressure(const Medium& medium, const Material& fluid, S r) {
  return bulk_modulus(fluid.density, fluid.sound_speed) * positive(S(real(1) - r / (real(0.8) * medium.spacing)));
}

// Returns the force of solid particle j on fluid particle i [N], of a solid that does not act by its geometry
// (walls.h). vp_j: the particle's velocity. wall_j: the pressure that the solid shows to the fluid (w) and the velocity
// that makes the mean of fluid and wall the wall's own at its surface (boundary.h). Such solids keep artificial
// viscosity beside their springs: without either, the wall's extrapolated pressure can feed sound waves.
template <class Kernel, class S>
PALP_HD inline Vec3Of<S> wall_pair_force(const Medium& medium, const Kernel& kernel, Tag tag_i, const Packed& xV_i,
                                         const Packed& vp_i, S V_j, const PackedOf<S>& vp_j, const PackedOf<S>& wall_j,
                                         const Vec3Of<S>& x_ij, S r2) {
  const S r = Eigen::numext::sqrt(r2), VVF = xV_i.w * V_j * kernel.F(r);
  const Material& fluid = medium.material[tag_i.material()];
  const Vec3Of<S> v_i = vp_i.xyz().template cast<S>(), v_ij = v_i - vp_j.xyz();
  const S along = acting_pressure(medium, vp_i.w) + wall_j.w + guarding_pressure(medium, fluid, r) -
                  artificial_pressure(medium, fluid.sound_speed, fluid.density, v_ij, x_ij, r2);
  return VVF * (along * x_ij - S(real(2) * fluid.viscosity) * (v_i - wall_j.xyz()));
}

// Writes the acceleration of each fluid particle [m/s^2] into acceleration[i], but for what solids add that act by
// their geometry (walls.h).
template <class Fluids, class Bonds, class Kernel>
struct FluidForce {
  ParticleView state;
  const Packed* wall;  // null without solids
  CellGrid grid;
  Kernel kernel;
  Medium medium;
  const Forcing* forcing;
  Packed* acceleration;
  Bonds bonds;

  // Returns the force on a particle [N]. pairs: by_lanes().
  template <class Pairs>
  PALP_HD Vec3 force_on(std::uint32_t i, Pairs pairs) const {
    using S = typename Pairs::Real;
    const Tag tag_i = state.tag[i];
    const Packed xV_i = state.xV[i], vp_i = state.vp[i];
    const Material& material_i = medium.material[tag_i.material()];
    const auto solid_i = bonds.solid(state, i);
    Vec3Of<S> force(0, 0, 0);
    for_neighbors(grid, state.xV, xV_i.xyz(), kernel.support, pairs,
                  [&](const auto& j, const PackedOf<S>& xV_j, const Vec3Of<S>& x_ij, S r2) PALP_INLINE {
                    const PackedOf<S> vp_j = fetch<S>(state.vp, j);
                    const std::uint32_t first = first_of(j);
                    const Tag tag_j = Fluids::tag_of(state, first, tag_i);
                    const bool fluid_j = Fluids::is_fluid(tag_j);
                    if (!fluid_j && tag_j.by_geometry()) return;
                    const S share = bonds.share(tag_i, solid_i, tag_j, bonds.solid(state, first));
                    if (fluid_j)
                      force += share * fluid_pair_force<Fluids>(medium, kernel, material_i, tag_i, xV_i, vp_i, tag_j,
                                                                xV_j.w, vp_j, x_ij, r2);
                    else
                      force += share * wall_pair_force(medium, kernel, tag_i, xV_i, vp_i, xV_j.w, vp_j,
                                                       fetch<S>(wall, j), x_ij, r2);
                  });
    return pairs.sum(force);
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = state.tag[i];
    if (!tag_i.is_fluid()) return;
    const auto alike = [&](std::uint32_t j) { return Fluids::alike(state, j, tag_i); };
    const Vec3 force =
        by_lanes(team, bonds.leaves_all(bonds.solid(state, i)), alike, [&](auto pairs) { return force_on(i, pairs); });
    if (team.leader()) acceleration[i] = pack(force / state.mass[i] + forcing->gravity + forcing->body_force, 0);
  }
};

}  // namespace palp
