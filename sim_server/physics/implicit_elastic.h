// Elastic bodies by an implicit solve, for those so stiff that explicit sub-steps would be too many: backward Euler
// with one Newton step, by conjugate gradients without a matrix. Method "accurate" without yield and tearing; particles
// that are bonded stay where they are.
//
// symbol      meaning                                                        source
// x*          x + dt v
// y           what the step adds to v, v' = v + y, x' = x + dt v':           zero where a body is in equilibrium,
//             (M + dt C + dt^2 K) y = dt (f + g)                             however few the rounds
// g           all other forces, gravity included
// R, R*       rotations of the neighbourhoods at x, and at x*                rotation.h
// f           elastic force of the strain at x*, but along the axes of x:    a turn is not taken for strain, and
//             stress R R*^T P(F*), damping along x_ji                        x cross f sums to zero
// K           dP = R (2 mu sym A + lambda tr A I), A = R^T dF: the slope     symmetric, never negative
//             of P with R fixed and without stress
// C           10 eta V_i V_j F x x^T, x = x_ji / |x_ji|                      elastic.h
// hourglass   h_i of elastic.h: linear, so K has the same
//
// In the linear problem a vibration of frequency w keeps 1 / sqrt(1 + (w dt)^2) of its amplitude in a step: a slow one
// is damped like w dt / 2 of critical, one that is faster than the step is at rest after a few. K need not be exact for
// that: any between half of the true slope and more leaves a step stable; y is small where K is too stiff.
//
// The solver is conjugate_gradients.h. A bonded particle has 1 / m = 0: its r is the impulse on it of all that is
// bonded to it. Contact (elastic_contact.h) adds a block to each particle's row, and its push to r.
#pragma once

#include "sim_server/physics/elastic.h"

namespace palp {

// The scalars of a round of the solve.
struct SolveRound {
  real gamma, alpha;
  real work;   // sum of alpha gamma up to here: y's energy, kinetic and elastic [J]
  bool ended;  // the next round would change nothing
};

struct ImplicitViews {
  std::uint32_t rounds = 0, parts = 0;  // rounds of the solve; parts of the particles that are summed separately
  Packed* pair = nullptr;               // in the order of ElasticViews::neighbor: X_ji; V_j F [m, 1/m^2]
  Packed* predicted = nullptr;          // u at x* [m]
  Quat* rotation = nullptr;             // R*
  Packed* residual = nullptr;           // r [kg m/s]; 1 / m
  Packed* scaled = nullptr;             // z [m/s]
  Packed* image = nullptr;              // w [kg m/s]
  Packed* direction = nullptr;          // p [m/s]
  Packed* advance = nullptr;            // s [kg m/s]
  Packed* change = nullptr;             // y [m/s]
  Packed* outer = nullptr;              // impulse of all but elasticity [kg m/s]
  Packed* sums = nullptr;               // by part: gamma, delta
  SolveRound* round = nullptr;
  real* unsolved = nullptr;  // largest share of y's energy in this haptic step that the last round still changed
  std::uint32_t free_bodies = 0;
  // contact's part of the matrix: the impulse on a particle that a unit of its y takes [kg]; null where none can touch
  Mat3* hold = nullptr;
  const std::uint32_t* free_body = nullptr;  // indices of the bodies that are bonded to nothing
  real min_work = 0;                         // change of y's energy below which a round is the last [J]
};

// Lists, once, the constants of each pair of neighbours.
struct ListPairs {
  ElasticViews elastic;
  ImplicitViews solve;
  CellGrid grid;
  WendlandC2 kernel;

  PALP_HD void operator()(std::uint32_t i) const {
    for (std::uint32_t k = elastic.first[i]; k < elastic.first[i + 1]; ++k) {
      const Packed X_j = elastic.rest[elastic.bond(k).j()];
      const Vec3 X_ji = rest_separation(grid, elastic.rest[i], X_j);
      solve.pair[k] = pack(X_ji, X_j.w * kernel.F(X_ji.norm()));
    }
  }
};

// Clears the forces where nothing else has set them.
struct ClearForce {
  BodyViews bodies;
  PALP_HD void operator()(std::uint32_t i) const { bodies.force[i] = Packed{0, 0, 0, 0}; }
};

// Sets x* and the start of the solve: r = dt g.
struct BeginImplicit {
  ElasticViews elastic;
  ImplicitViews solve;
  BodyViews bodies;
  Medium medium;
  CellGrid grid;
  const Forcing* forcing;

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = elastic.tag[i];
    const bool free = tag.kind() == BodyKind::elastic;
    const real mass = medium.material[tag.material()].density * elastic.rest[i].w;
    Vec3 v(0, 0, 0), impulse(0, 0, 0);
    if (free) {
      const Vec3 x = elastic.rest[i].xyz() + elastic.u[i].xyz();
      const Surroundings around = surroundings(grid, *forcing, x, medium.dt);
      v = around.kept * elastic.v[i].xyz();
      impulse = around.kept * medium.dt * (bodies.force[i].xyz() + mass * around.pull);
      bodies.force[i] = pack(mass * around.kept * around.pull, 0);
    }
    elastic.v[i] = pack(v, 0);
    solve.predicted[i] = pack(elastic.u[i].xyz() + medium.dt * v, 0);
    solve.outer[i] = pack(impulse, 0);
    solve.residual[i] = pack(impulse, free ? real(1) / mass : real(0));
    solve.direction[i] = solve.advance[i] = solve.change[i] = Packed{0, 0, 0, 0};
  }
};

// Computes R, F and R*, and the factor of X_ji in f, R R*^T P(F*) L - beta E (F* - I), into ElasticViews::stress.
struct PredictedStrain {
  ElasticViews elastic;
  ImplicitViews solve;
  Medium medium;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Vec3 u_i = elastic.u[i].xyz(), ahead_i = solve.predicted[i].xyz();
    Mat3 now = Mat3::Zero(), ahead = Mat3::Zero();
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      const ElasticBond bond = elastic.bond(k);
      if (!bond.in_mine()) continue;
      const std::uint32_t j = bond.j();
      const Packed pair = solve.pair[k];
      const Vec3 weighted = pair.w * pair.xyz();
      now += (elastic.u[j].xyz() - u_i) * weighted.transpose();
      ahead += (solve.predicted[j].xyz() - ahead_i) * weighted.transpose();
    }
    now = team_sum(team, now);
    ahead = team_sum(team, ahead);
    if (!team.leader()) return;
    const Mat3 L = elastic.correction[i];
    const Mat3 within = elastic.projection != nullptr ? elastic.projection[i] : Mat3(Mat3::Identity());
    const Mat3 across = Mat3::Identity() - within;  // where neighbours span no space nothing is strained
    const Material& m = medium.material[elastic.tag[i].material()];
    Mat3 F = within + now * L, F_ahead = within + ahead * L;
    const Quat q = closest_rotation(F, elastic.rotation[i]), q_ahead = closest_rotation(F_ahead, solve.rotation[i]);
    const Mat3 R = q.toRotationMatrix(), R_ahead = q_ahead.toRotationMatrix();
    F += R * across;
    F_ahead += R_ahead * across;
    elastic.rotation[i] = q;
    elastic.gradient[i] = F;
    solve.rotation[i] = q_ahead;
    Mat3 P = R * (R_ahead.transpose() * elastic_stress(m, F_ahead, R_ahead));
    if (elastic.pressed != nullptr) P += contact_stress(elastic.pressed[i], F);
    elastic.stress[i] = P * L - hold_of(m) * (ahead * L);
  }
};

// Completes the residual to begin with: r = dt (f + g).
struct PredictedForce {
  ElasticViews elastic;
  ImplicitViews solve;
  Medium medium;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Material& m = medium.material[elastic.tag[i].material()];
    const real V_i = elastic.rest[i].w;
    const Vec3 u_i = elastic.u[i].xyz(), ahead_i = solve.predicted[i].xyz(), v_i = elastic.v[i].xyz();
    const Mat3 stress_i = elastic.stress[i];
    Vec3 force(0, 0, 0);
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      const ElasticBond bond = elastic.bond(k);
      const std::uint32_t j = bond.j();
      const Packed pair = solve.pair[k];
      const Material& m_j = medium.material[elastic.tag[j].material()];
      const Vec3 X_ji = pair.xyz(), x_ji = X_ji + elastic.u[j].xyz() - u_i;
      const real VVF = V_i * pair.w;
      const Vec3 ahead_ji = solve.predicted[j].xyz() - ahead_i;
      const real hold = bond.sum(hold_of(m), hold_of(m_j));
      force += VVF * pair_force(bond.sum(stress_i, elastic.stress[j]), X_ji, hold, ahead_ji);
      const real r2 = x_ji.squaredNorm(), damping = real(5) * (m.damping + m_j.damping);
      if (damping > real(0) && r2 > real(0))
        force += (VVF * damping * (elastic.v[j].xyz() - v_i).dot(x_ji) / r2) * x_ji;
    }
    force = team.sum(force);
    if (!team.leader()) return;
    const Packed r = solve.residual[i];
    solve.residual[i] = pack(r.xyz() + medium.dt * force, r.w);
  }
};

// Returns z = (m + hold)^-1 r: mass, and contact, which would else take many rounds.
PALP_HD inline Vec3 preconditioned(const ImplicitViews& solve, std::uint32_t i, const Packed& r) {
  if (!(r.w > real(0))) return Vec3(0, 0, 0);
  if (solve.hold == nullptr || solve.hold[i].isZero(0)) return r.w * r.xyz();
  const Mat3 held = Mat3::Identity() + r.w * solve.hold[i];
  return held.inverse() * (r.w * r.xyz());
}

// Sets z for the first round.
struct BeginSolve {
  ImplicitViews solve;
  PALP_HD void operator()(std::uint32_t i) const {
    solve.scaled[i] = pack(preconditioned(solve, i, solve.residual[i]), 0);
  }
};

// Computes the factor of X_ji in K z, as PredictedStrain does that in f.
struct StrainChange {
  ElasticViews elastic;
  ImplicitViews solve;
  Medium medium;
  std::uint32_t round;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    if (round > 0 && solve.round[round - 1].ended) return;
    const Vec3 z_i = solve.scaled[i].xyz();
    Mat3 change = Mat3::Zero();
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      const ElasticBond bond = elastic.bond(k);
      if (!bond.in_mine()) continue;
      const std::uint32_t j = bond.j();
      const Packed pair = solve.pair[k];
      change += (solve.scaled[j].xyz() - z_i) * (pair.w * pair.xyz()).transpose();
    }
    change = team_sum(team, change);
    if (!team.leader()) return;
    const Mat3 L = elastic.correction[i], R = elastic.rotation[i].toRotationMatrix();
    const Material& m = medium.material[elastic.tag[i].material()];
    change = change * L;
    Mat3 A = R.transpose() * change;
    if (elastic.projection != nullptr) A = elastic.projection[i] * A;  // motion out of the plane turns it
    const Mat3 T = m.shear * (A + A.transpose()) + m.lame * A.trace() * Mat3::Identity();
    const Mat3 P = elastic.projection != nullptr ? Mat3(R * (elastic.projection[i] * T)) : Mat3(R * T);
    elastic.stress[i] = pair_factor(P, L, hold_of(m), change);
  }
};

// Computes w = A z.
struct ForceChange {
  ElasticViews elastic;
  ImplicitViews solve;
  Medium medium;
  std::uint32_t round;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    if (round > 0 && solve.round[round - 1].ended) return;
    const Material& m = medium.material[elastic.tag[i].material()];
    const Packed r_i = solve.residual[i];
    const real V_i = elastic.rest[i].w;
    const Vec3 u_i = elastic.u[i].xyz(), z_i = solve.scaled[i].xyz();
    const Mat3 stress_i = elastic.stress[i];
    const real dt = medium.dt;
    Vec3 impulse(0, 0, 0);
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      const ElasticBond bond = elastic.bond(k);
      const std::uint32_t j = bond.j();
      const Packed pair = solve.pair[k];
      const Material& m_j = medium.material[elastic.tag[j].material()];
      const Vec3 X_ji = pair.xyz(), z_ji = solve.scaled[j].xyz() - z_i;
      const real VVF = V_i * pair.w;
      const real hold = bond.sum(hold_of(m), hold_of(m_j)), damping = real(5) * (m.damping + m_j.damping);
      impulse += (dt * dt * VVF) * pair_force(bond.sum(stress_i, elastic.stress[j]), X_ji, hold, z_ji);
      if (!(damping > real(0))) continue;
      const Vec3 x_ji = X_ji + elastic.u[j].xyz() - u_i;
      const real r2 = x_ji.squaredNorm();
      if (r2 > real(0)) impulse += (dt * VVF * damping * z_ji.dot(x_ji) / r2) * x_ji;
    }
    impulse = team.sum(impulse);
    if (!team.leader()) return;
    if (solve.hold != nullptr) impulse -= mat_vec(solve.hold[i], z_i);
    if (r_i.w > real(0)) impulse -= z_i / r_i.w;
    solve.image[i] = pack(-impulse, 0);
  }
};

// Sets velocities, and the forces that have acted, gravity left out; on bonded particles these are the forces of the
// bonds beside those that acted already.
struct EndImplicit {
  ElasticViews elastic;
  ImplicitViews solve;
  BodyViews bodies;
  Medium medium;

  PALP_HD void operator()(std::uint32_t i) const {
    const Packed r = solve.residual[i];
    const Vec3 y = solve.change[i].xyz(), before = bodies.force[i].xyz();
    if (!(r.w > real(0))) {
      bodies.force[i] = pack(before + r.xyz() / medium.dt, 0);
      return;
    }
    elastic.v[i] = pack(elastic.v[i].xyz() + y, 0);
    bodies.force[i] = pack(y / (r.w * medium.dt) - before, 0);  // before: the weight
  }
};

// Moves the particles; takes the place of MoveElastic.
struct MoveImplicit {
  ElasticViews elastic;
  BodyViews bodies;
  Medium medium;

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = elastic.tag[i];
    if (tag.kind() != BodyKind::elastic) return;
    const Vec3 u = elastic.u[i].xyz() + medium.dt * elastic.v[i].xyz();
    elastic.u[i] = pack(u, 0);
    const BodyState& body = bodies.body[tag.body()];
    bodies.local[i] = pack(body.q.conjugate() * (elastic.rest[i].xyz() + u - body.x), 0);
  }
};

}  // namespace palp
