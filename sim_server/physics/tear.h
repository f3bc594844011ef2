// Tearing: bonds between neighbours at rest that break for good.
//
// symbol     meaning                                                          source
// C = F^T F  of the bonds left; l^2 its greatest value, N its axis at rest
// s_ij       (F_i N_i / |F_i N_i|).x_ji / (N_i.X_ji), stretch of a pair along the greatest stretch of i, and of j
// breaks     when either is above 1 + tear_strain                             Chakraborty & Shaw 2013, Islam & Peng
// 2019 L_i        (sum_j V_j F X_ji X_ji^T)^-1 of the bonds left: affine fields stay exact on both sides of a tear
//
// Those papers break a pair by its own stretch. With corrected gradients that would not do: of the bonds across a tear
// the slanting ones stretch less, and while the last of them is left L makes it carry all the stress of the ones
// before. Measured along the greatest stretch, the pairs across a tear are all stretched alike and break together. A
// tear sets free the energy of about one spacing on each side, so the energy for a tear's area depends on the spacing;
// the strain does not.
//
// Both particles of a pair judge it by the same numbers in the same order, so it breaks in both lists in the same
// sub-step, and forces stay equal and opposite. Torn faces do not push each other: contact is between bodies.
#pragma once

#include "sim_server/physics/elastic.h"

namespace palp {

// Pairs that lie within 30 degrees of the plane of a tear are not across it.
inline constexpr real kAcross = real(0.5);

// What has lost more than this share of its neighbourhood bears less the more it loses: few neighbours fit any noise as
// strain, whose energy would come from nothing, and a few stiff bonds would need shorter steps. What yields has a state
// that was found with all of its neighbours and bears nothing when half as many are left again.
inline constexpr real kCrumbles = real(0.5);

// L from the moment sum V F X X^T, and what the neighbours span: axes of less than a thousandth of the largest do not
// count (elastic_store.cpp).
struct GradientCorrection {
  Mat3 inverse, projection;
};

PALP_HD inline GradientCorrection gradient_correction(const Mat3& moment) {
  constexpr real kFlat = real(1e-3);
  const PrincipalAxes principal = principal_axes(moment);
  const real least = kFlat * principal.value.maxCoeff();
  GradientCorrection c{Mat3::Zero(), Mat3::Zero()};
  for (int a = 0; a < 3; ++a) {
    if (!(principal.value[a] > least)) continue;
    const Vec3 n = principal.axis.col(a);
    const Mat3 along = n * n.transpose();
    c.inverse += along / principal.value[a];
    c.projection += along;
  }
  return c;
}

// Breaks what is overstretched and corrects the gradients of the particles that it was torn from. It reads the strain
// of the last sub-step and the places of this one.
struct TearBonds {
  ElasticViews elastic;
  CellGrid grid;
  WendlandC2 kernel;
  Medium medium;

  // Whether the pair of displacement X_ji at rest, x_ji now, is torn by the stretch of one of its particles.
  PALP_HD bool pulled_apart(std::uint32_t by, const Vec3& X_ji, const Vec3& x_ji, real most) const {
    const Packed pull = elastic.pull[by];
    if (!(pull.w > real(0))) return false;
    const Vec3 N = pull.xyz(), n = times(elastic.gradient[by], N);
    const real across = N.dot(X_ji), now = n.dot(x_ji) / n.norm();
    if (across * across < kAcross * kAcross * X_ji.squaredNorm()) return false;
    return now / across > most;
  }

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

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    real broken = 0;
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      if (elastic.torn[k] != 0 || !breaks(i, elastic.neighbor[k])) continue;
      elastic.torn[k] = 1;
      broken += real(1);
    }
    if (!(team.sum(broken) > real(0))) return;
    const Packed X_i = elastic.rest[i];
    Mat3 moment = Mat3::Zero();
    real whole = 0;
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      const Packed X_j = elastic.rest[elastic.neighbor[k]];
      const Vec3 X_ji = rest_separation(grid, X_i, X_j);
      const real weight = X_j.w * kernel.F(X_ji.norm());
      whole += weight * X_ji.squaredNorm();
      if (elastic.torn[k] == 0) moment += weight * X_ji * X_ji.transpose();
    }
    moment = team_sum(team, moment);
    whole = team.sum(whole);
    if (!team.leader()) return;
    const GradientCorrection c = gradient_correction(moment);
    elastic.correction[i] = c.inverse;
    elastic.projection[i] = c.projection;
    real left = moment.trace() / (kCrumbles * whole);
    if (medium.material[elastic.tag[i].material()].yield > real(0)) left = real(2) * left - real(1);
    elastic.bearing[i] = left < real(1) ? (left > real(0) ? left : real(0)) : real(1);
  }
};

}  // namespace palp
