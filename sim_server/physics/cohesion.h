// Surface tension and adhesion: particles attract each other, from a third of the support radius on, and repel closer
// by (Tartakovsky & Meakin 2005). The strength that gives a surface tension follows from it (Rayleigh, Kirkwood & Buff;
// Tartakovsky & Panchenko 2016), so materials state N/m. Central pair forces: linear and angular momentum are kept.
//
// symbol    meaning                                                            unit      source
// f_ij      -V_i V_j s_ij phi(r/H) x_ij / r                                    N
// phi(q)    -cos(3 pi q / 2), 0 from q = 1 on                                  -         Tartakovsky & Meakin 2005
// s_ii      sigma / N, N = 0.54 (pi/8) H^5 int_0^1 q^4 phi dq                  N/m^6     Tartakovsky & Panchenko 2016
// s_ij      min(s_ii, s_jj) of two fluids: sigma_ij = |sigma_i - sigma_j|      N/m^6     Antonow's rule
// s_is      adhesion / N of a fluid and a solid                                N/m^6
//
// 0.54 is measured: drops of 7 dx with H = 3 and 4 dx had 0.53 and 0.55 of the pressure 2 sigma / R that the integral
// alone gives, because the pressure that balances the attraction presses along the surface, too.
//
// A drop rests on a solid at the angle cos(theta) = 2 adhesion / sigma - 1 (Young & Dupre: parting them takes 2
// adhesion a unit of area): 0 runs off as a ball, half of sigma stands at a right angle, all of it spreads. Within a
// fluid the attraction is balanced by a pressure of some 17 sigma / H, which no wall and no surface feels
// (fluid_pressure.h takes it off).
#pragma once

#include "sim_server/physics/rigid.h"

namespace palp {

struct CohesionMedium {
  real tension[kMaxMaterials];   // s_ii
  real adhesion[kMaxMaterials];  // s_is
};

// The integral int_0^1 q^4 phi dq = 1/a - 12/a^3 + 24/a^5 with a = 3 pi / 2.
inline constexpr double kCohesionIntegral = 0.107863;
// The share of the surface tension that the pressure leaves which balances the attraction; measured
// (cohesion_test.cpp).
inline constexpr double kCohesionShare = 0.54;

// Returns N [m^5].
inline double cohesion_norm(double support) {
  const double H2 = support * support;
  return kCohesionShare * static_cast<double>(kPi) / 8 * kCohesionIntegral * H2 * H2 * support;
}

template <class S>
PALP_HD inline S cohesion_phi(S q) {
  return q < S(1) ? -Eigen::numext::cos(S(1.5) * kPiOf<S> * q) : S(0);
}

// Returns s_ij of two particles [N/m^6].
PALP_HD inline real cohesion_strength(const CohesionMedium& medium, Tag a, Tag b) {
  if (a.is_fluid() && b.is_fluid()) {
    const real s_a = medium.tension[a.material()], s_b = medium.tension[b.material()];
    return s_a < s_b ? s_a : s_b;
  }
  if (!a.is_fluid() && !b.is_fluid()) return real(0);
  return medium.adhesion[a.is_fluid() ? a.material() : b.material()];
}

// Adds the attraction to the acceleration of fluids and to the forces on the particles of bodies whose wrench is asked
// for.
struct CohesionForce {
  ParticleView state;
  BodyViews bodies;  // null pointers without solids
  CellGrid grid;
  real support;
  bool uniform;
  CohesionMedium medium;
  Packed* acceleration;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = state.tag[i];
    const BodyState* body = tag_i.is_fluid() ? nullptr : &bodies.body[tag_i.body()];
    if (body != nullptr && body->force_first == kNone) return;
    const Packed xV_i = state.xV[i];
    Vec3 force(0, 0, 0);
    for_neighbors(grid, state.xV, xV_i.xyz(), support, team,
                  [&](std::uint32_t j, const Packed& xV_j, const Vec3& x_ij, real r2) {
                    if (!(r2 > real(0))) return;
                    const Tag tag_j = uniform ? tag_i : state.tag[j];
                    const real r = Eigen::numext::sqrt(r2);
                    force -= (xV_j.w * cohesion_strength(medium, tag_i, tag_j) * cohesion_phi(r / support) / r) * x_ij;
                  });
    force = xV_i.w * team.sum(force);
    if (!team.leader()) return;
    if (body == nullptr) {
      acceleration[i] = pack(acceleration[i].xyz() + force / state.mass[i], 0);
    } else {
      Packed& total = bodies.force[body->force_first + state.id[i] - body->first];
      total = pack(total.xyz() + force, total.w);
    }
  }
};

}  // namespace palp
