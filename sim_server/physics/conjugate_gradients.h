// The linear solver of implicit elasticity (implicit_elastic.h): conjugate gradients without a matrix.
//
// Preconditioned with the mass, so that momentum is exact however few rounds there are, and with contact (hold), whose
// stiffness would else take many of them; in the form with one sum a round (Chronopoulos & Gear 1989).
// z = (m + hold)^-1 r:
//   w = A z, gamma = r.z, delta = w.z, beta = gamma / gamma', alpha = gamma / (delta - beta gamma / alpha')
//   p = z + beta p, s = w + beta s, y += alpha p, r -= alpha s
// The plan fixes the number of rounds; those after the last that changed something return at once.
#pragma once

#include "sim_server/physics/implicit_elastic.h"

namespace palp {

// The share of y's energy that a round at least changes; less is lost in the scalar's rounding.
inline constexpr real kMinWork = sizeof(real) == 4 ? real(1e-8) : real(1e-12);

// Returns the index of the first particle of a part.
PALP_HD inline std::uint32_t first_of_part(const ElasticViews& elastic, const ImplicitViews& solve,
                                           std::uint32_t part) {
  return static_cast<std::uint32_t>(std::uint64_t(elastic.count) * part / solve.parts);
}

// Sums gamma and delta of each part; one team a part. What sleeps (elastic_sleep.h) has r = z = 0 and adds nothing.
struct SumRound {
  ElasticViews elastic;
  ImplicitViews solve;
  std::uint32_t round;
  const Tag* sleepers;  // null: all are awake

  template <class Team>
  PALP_HD void operator()(std::uint32_t part, Team team) const {
    if (round > 0 && solve.round[round - 1].ended) return;
    const std::uint32_t end = first_of_part(elastic, solve, part + 1);
    real gamma = 0, delta = 0;
    for (std::uint32_t i = first_of_part(elastic, solve, part) + team.lane(); i < end; i += team.size()) {
      if (sleepers != nullptr && sleepers[i].asleep()) continue;
      const Vec3 z = solve.scaled[i].xyz();
      gamma += solve.residual[i].xyz().dot(z);
      delta += solve.image[i].xyz().dot(z);
    }
    gamma = team.sum(gamma);
    delta = team.sum(delta);
    if (team.leader()) solve.sums[part] = {gamma, delta, 0, 0};
  }
};

// Advances p, s, y and r; one team a part. Every team adds up the parts' sums itself.
struct AdvanceRound {
  ElasticViews elastic;
  ImplicitViews solve;
  std::uint32_t round;
  const Tag* sleepers;  // null: all are awake

  // Returns the scalars of this round, and beta.
  PALP_HD SolveRound next(real gamma, real delta, real& beta) const {
    SolveRound out{gamma, 0, 0, true};
    beta = 0;
    real slope = delta;
    if (round > 0) {
      const SolveRound& before = solve.round[round - 1];
      out.work = before.work;
      if (before.ended) return out;
      beta = gamma / before.gamma;
      slope -= beta * gamma / before.alpha;
    }
    // what is not finite must show in the particles, where health finds it (health.h)
    if (!Eigen::numext::isfinite(gamma + slope)) out.alpha = gamma + slope;
    if (!(gamma > real(0) && slope > real(0) && out.alpha == real(0))) return out;
    out.alpha = gamma / slope;
    const real work = out.alpha * gamma;
    out.work += work;
    out.ended = !(work > solve.min_work && work > kMinWork * out.work);
    return out;
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t part, Team team) const {
    real gamma = 0, delta = 0, beta = 0;
    for (std::uint32_t k = team.lane(); k < solve.parts; k += team.size()) {
      gamma += solve.sums[k].x;
      delta += solve.sums[k].y;
    }
    gamma = team.sum(gamma);
    delta = team.sum(delta);
    const SolveRound now = next(gamma, delta, beta);
    if (part == 0 && team.leader()) {
      solve.round[round] = now;
      const real left = now.ended ? real(0) : now.alpha * gamma / (now.work + real(1e4) * solve.min_work);
      if (round + 1 == solve.rounds && !(left <= *solve.unsolved)) *solve.unsolved = left;
    }
    if (now.alpha == real(0)) return;
    const std::uint32_t end = first_of_part(elastic, solve, part + 1);
    for (std::uint32_t i = first_of_part(elastic, solve, part) + team.lane(); i < end; i += team.size()) {
      if (sleepers != nullptr && sleepers[i].asleep()) continue;
      const Packed r = solve.residual[i];
      const Vec3 p = solve.scaled[i].xyz() + beta * solve.direction[i].xyz();
      const Vec3 s = solve.image[i].xyz() + beta * solve.advance[i].xyz();
      solve.direction[i] = pack(p, 0);
      solve.advance[i] = pack(s, 0);
      solve.change[i] = pack(solve.change[i].xyz() + now.alpha * p, 0);
      const Packed left = pack(r.xyz() - now.alpha * s, r.w);
      solve.residual[i] = left;
      solve.scaled[i] = pack(preconditioned(solve, i, left), 0);
    }
  }
};

}  // namespace palp
