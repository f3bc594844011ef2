// Tearing: bonds between neighbours at rest that break for good.
//
// symbol     meaning                                                          source
// C          F^T F of the bonds left; l^2: greatest value, N: its axis at rest
// s_ij       (F_i N_i / |F_i N_i|).x_ji / (N_i.X_ji), stretch of a pair
//            along the greatest stretch of i; s_ji along that of j
// breaks     when either is above 1 + tear_strain                             Chakraborty & Shaw 2013; Islam & Peng
// 2019 L_i        (sum_j V_j F X_ji X_ji^T)^-1 of the bonds left: affine fields    gradient_correction.h
//            stay exact on both sides of a tear
//
// Those papers break a pair by its own stretch. With corrected gradients that would not do: of the bonds across a tear
// the slanting ones stretch less, and while the last of them is left L makes it carry all the stress of the ones
// before. Measured along the greatest stretch, the pairs across a tear are all stretched alike and break together. A
// tear sets free the energy of about one spacing on each side, so the energy for a tear's area depends on the spacing;
// the strain does not.
//
// The bonds that are left fit the same places as another deformation, which may store more than the one before, most of
// all where matter hardly compresses: a block of nu = 0.49 that was blown to bits gained fourteen times its energy. So
// a torn neighbourhood bears the share of its stress with which a tear leaves it no more energy than it found.
//
// Both particles of a pair judge it by the same numbers in the same order, so it breaks in both lists in the same
// sub-step, and forces stay equal and opposite. Torn faces do not push each other: contact is between bodies.
#pragma once

#include "sim_server/physics/elastic.h"
#include "sim_server/physics/gradient_correction.h"

namespace palp {

// The cosine of the angle between a pair and the greatest stretch below which the pair is not across a tear: pairs
// within 30 degrees of its plane are not.
inline constexpr real kMinTearCosine = real(0.5);

// The share of its neighbourhood below which a particle's integrity falls with what is left: few neighbours fit any
// noise as strain, and a few stiff bonds would need shorter steps. Matter that yields has a state that was found with
// all of its neighbours, so its integrity is zero at half of this share.
inline constexpr real kIntegrityOnset = real(0.5);

// The mark of a bond that breaks in this sub-step, until its particle's correction follows.
inline constexpr std::uint8_t kTearsNow = 2;

// Breaks overstretched bonds and corrects the gradients of the particles that have lost some. It reads the strain of
// the last sub-step and the places of this one.
struct TearBonds {
  ElasticViews elastic;
  CellGrid grid;
  WendlandC2 kernel;
  Medium medium;

  // Returns true when the pair of separation X_ji at rest, x_ji now, is stretched to more than `limit` along the
  // greatest stretch of its particle `by`.
  PALP_HD bool pulled_apart(std::uint32_t by, const Vec3& X_ji, const Vec3& x_ji, real limit) const {
    const Packed stretch = elastic.stretch[by];
    if (!(stretch.w > real(0))) return false;
    const Vec3 N = stretch.xyz(), n = mat_vec(elastic.gradient[by], N);
    const real across = N.dot(X_ji), now = n.dot(x_ji) / n.norm();
    if (across * across < kMinTearCosine * kMinTearCosine * X_ji.squaredNorm()) return false;
    return now / across > limit;
  }

  // Returns true when the bond of a pair breaks now.
  PALP_HD bool breaks(std::uint32_t i, std::uint32_t j) const {
    const std::uint32_t a = i < j ? i : j, b = i < j ? j : i;
    const real tear_a = medium.material[elastic.tag[a].material()].tear,
               tear_b = medium.material[elastic.tag[b].material()].tear;
    const real tear = tear_a > real(0) && (!(tear_b > real(0)) || tear_a < tear_b) ? tear_a : tear_b;
    if (!(tear > real(0))) return false;
    const Vec3 X = rest_separation(grid, elastic.rest[a], elastic.rest[b]);
    const Vec3 x = X + elastic.u[b].xyz() - elastic.u[a].xyz();
    return pulled_apart(a, X, x, real(1) + tear) || pulled_apart(b, X, x, real(1) + tear);
  }

  // Returns the energy per volume at rest that a particle would store without its integrity [J/m^3]. displaced: sum V F
  // u_ji X_ji^T.
  PALP_HD real energy_of(std::uint32_t i, const Mat3& displaced, const GradientCorrection<real>& c) const {
    const Material& m = medium.material[elastic.tag[i].material()];
    const bool yields = m.yield > real(0);
    const DeformationGradient d = deformation_of(displaced, c.inverse, c.projection, yields, elastic.rotation[i]);
    if (!yields) return elastic_energy(m, d.F, d.q.toRotationMatrix());
    const Mat3 Fe = d.F * elastic.plastic[i];
    return plastic_energy(m, Fe, closest_rotation(Fe, d.q).toRotationMatrix());
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    real broken = 0;
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      if (elastic.torn[k] != 0 || !breaks(i, elastic.bond(k).j())) continue;
      elastic.torn[k] = kTearsNow;
      broken += real(1);
    }
    if (!(team.sum(broken) > real(0))) return;
    const Packed X_i = elastic.rest[i];
    const Vec3 u_i = elastic.u[i].xyz();
    Mat3 moment = Mat3::Zero(), before = Mat3::Zero(), after = Mat3::Zero();  // the latter: displaced of energy_of()
    real whole = 0;
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      const ElasticBond bond = elastic.bond(k);
      const std::uint32_t j = bond.j();
      const Packed X_j = elastic.rest[j];
      const Vec3 X_ji = rest_separation(grid, X_i, X_j);
      const real weight = bond.in_mine() ? X_j.w * kernel.F(X_ji.norm()) : real(0);
      whole += weight * X_ji.squaredNorm();
      if (elastic.torn[k] == 1) continue;
      const Mat3 displaced = (weight * (elastic.u[j].xyz() - u_i)) * X_ji.transpose();
      before += displaced;
      if (elastic.torn[k] == kTearsNow) {
        elastic.torn[k] = 1;
        continue;
      }
      after += displaced;
      moment += weight * X_ji * X_ji.transpose();
    }
    moment = team_sum(team, moment);
    before = team_sum(team, before);
    after = team_sum(team, after);
    whole = team.sum(whole);
    if (!team.leader()) return;
    const GradientCorrection<real> was{elastic.correction[i], elastic.projection[i]},
        is = gradient_correction(moment, static_cast<real>(kFlatNeighborhood));
    elastic.correction[i] = is.inverse;
    elastic.projection[i] = is.projection;
    real left = moment.trace() / (kIntegrityOnset * whole);
    if (medium.material[elastic.tag[i].material()].yield > real(0)) left = real(2) * left - real(1);
    if (!(left > real(0))) left = real(0);
    // what the tear leaves may store no more than it found
    const real bore = elastic.integrity[i], had = bore * energy_of(i, before, was), has = energy_of(i, after, is);
    real bears = left < bore ? left : bore;
    if (bears * has > had) bears = had / has;
    elastic.integrity[i] = bears;
  }
};

}  // namespace palp
