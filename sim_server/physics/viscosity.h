// Viscosity where the explicit limit would cost more sub-steps than anything else: the whole sub-step is taken in s
// stages that apply the viscous forces alone, so a sub-step costs s passes instead of about s^2/4 sub-steps.
//
// symbol    meaning                                                   unit      source
// L Y       sum_j k_ij (Y_i - Y_j), symmetric                         N
// k_ij      V_i V_j 2 mu F min(l_i, l_j); mu harmonic between fluids  N s/m     fluid.h
// k_iw      V_i V_w 4 mu F min(l_i, l_w), w a particle of a solid     N s/m     below
// Y_0 = v,  Y_j = Y_j-1 + (j-1)/(j+2) (Y_j-1 - Y_j-2) + (2j+1)/(j+2) w dt (a - L Y_j-1 / m),  v' = Y_s
// w         4 / (s^2 + 3 s)                                           -         Skaras et al. 2021: RKG1, lambda = 3/2
// l_i       min(1, 0.95 / (w dt K_i / m_i)), K_i = sum_j k_ij         -         Gershgorin's bound on L
//
// Runge-Kutta-Gegenbauer is a Chebyshev-like iteration whose polynomial is exact to first order at every number of
// stages. A truncated implicit solve is not: it would lose a share of gravity and of what solids are owed. Each stage
// is a sum of pair forces, so momentum is kept to round-off; a flow that viscosity and the other forces a balance stays
// as it is, whatever the step; no part of the motion grows. l_i, which is 1 but for particles that have crowded or that
// the plan did not foresee, makes this hold however the particles lie.
//
// A solid is the limit of a very viscous medium whose surface lies midway between its particles and the fluid's: twice
// the pair coefficient (as heat.h has it), and the operator stays symmetric, which it is not with velocities
// extrapolated into walls. Rigid bodies and the particles of elastic ones take part with their masses, a body that a
// hand holds with its coupling (viscous_bodies.h): else drag would throw a light tool about. What a solid receives is
// the sum of its stages' forces, each with its share in Y_s.
#pragma once

#include "sim_server/physics/rigid.h"

namespace palp {

// The state of a rigid body in the stages.
struct ViscousBody {
  Vec3 v[2], w[2];   // at the last two stages [m/s, rad/s]
  Vec3 dv, dw;       // change in the sub-step by all forces but viscosity [m/s, rad/s]
  CoupledMass mass;  // the mass that viscosity moves
  real dt;           // sub-step [s]
  real limit;        // l
};

// The coefficients of the bodies beside a fluid particle (wall_drag.h), by their places among those that keep fluids
// out. Of more than kMost the weakest are left out.
struct WallDrag {  // NOLINT(bugprone-reserved-identifier): the name is the compiler's, as it copies the array of Vec3
  static constexpr int kMost = 3;
  std::uint32_t body[kMost];  // kNone: none
  real k[kMost];              // [N s/m]
  Vec3 foot[kMost];           // where it acts: on the surface, from the body's centre, world axes [m]
  PALP_HD void add(std::uint32_t place, real value, const Vec3& at) {
    int weakest = 0;
    for (int a = 1; a < kMost; ++a)
      if (k[a] < k[weakest]) weakest = a;
    if (!(value > k[weakest])) return;
    body[weakest] = place;
    k[weakest] = value;
    foot[weakest] = at;
  }
  // Returns the index of a body's entry, or kMost.
  PALP_HD int find(std::uint32_t place) const {
    int a = 0;
    while (a < kMost && body[a] != place) ++a;
    return a;
  }
  PALP_HD real sum() const { return k[0] + k[1] + k[2]; }
};
PALP_HD inline WallDrag no_drag() {
  const Vec3 none(0, 0, 0);
  return {{kNone, kNone, kNone}, {0, 0, 0}, {none, none, none}};
}

// Sums of K, K r, K r_a^2 and K r_b r_c over the particles beside a body.
struct DragMoments {
  real sum;
  Vec3 moment, squares, products;
  PALP_HD void add(real K, const Vec3& r) {
    sum += K;
    moment += K * r;
    squares += K * r.cwiseProduct(r);
    products += K * Vec3(r.y() * r.z(), r.z() * r.x(), r.x() * r.y());
  }
  // sum K (r^2 - r r^T)
  PALP_HD Mat3 turning() const {
    Mat3 out;
    out << squares.y() + squares.z(), -products.z(), -products.y(), -products.z(), squares.z() + squares.x(),
        -products.x(), -products.y(), -products.x(), squares.x() + squares.y();
    return out;
  }
};
PALP_HD inline DragMoments no_moments() { return {0, Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)}; }

// The couple on a body that turns (walls.h): P w - tr(P) w, with P the sum of 2 mu V slope r^T over the places r on
// its surface.
struct TurningDrag {
  Vec3 px, py, pz;  // P's columns
  PALP_HD void add(const Vec3& n, const Vec3& r) {
    px += r.x() * n;
    py += r.y() * n;
    pz += r.z() * n;
  }
  PALP_HD Vec3 torque(const Vec3& w) const {
    return w.x() * px + w.y() * py + w.z() * pz - (px.x() + py.y() + pz.z()) * w;
  }
};
PALP_HD inline TurningDrag no_turning() { return {Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0)}; }

struct ViscosityViews {
  Packed* stage[2] = {nullptr, nullptr};  // per particle: Y of the last two stages; l
  Packed* solid = nullptr;                // in the order of BodyViews::force: force of the last stage [N]; before the
                                          // first stage K [N s/m]
  ViscousBody* body = nullptr;            // by body
  const std::uint32_t* wall = nullptr;    // by place: bodies that act by their geometry
  WallDrag* drag = nullptr;               // by particle; null without such bodies
  WallWrench* drag_wrench = nullptr;      // of a stage, by part and place, as WallWrenches::wrench
  DragMoments* drag_moments = nullptr;    // likewise
  TurningDrag* turning = nullptr;         // likewise
};

// Returns the velocity of a body at r from its centre in a stage, and its limit l.
PALP_HD inline Packed stage_velocity(const ViscosityViews& viscosity, const BodyState& body, std::uint32_t index,
                                     std::uint32_t stage, const Vec3& r) {
  if (body.kind != BodyKind::rigid) return pack(body.v + body.w.cross(r), 1);
  const ViscousBody& b = viscosity.body[index];
  return pack(b.v[stage] + b.w[stage].cross(r), b.limit);
}

struct StageNumbers {
  std::uint32_t from;  // index of the array that holds Y_j-1; the other holds Y_j-2 and gets Y_j
  real carry;          // (j-1)/(j+2)
  real rate;           // (2j+1)/(j+2) w dt [s]
  real share;          // share of this stage's force in the mean over the sub-step
  bool last;
};

// Returns the numbers of stage j = 1..s. The shares are the weights of Y_s = Y_0 + dt sum_j share_j F(Y_j-1); they are
// positive and add to 1.
inline StageNumbers stage_numbers(int j, int s, double dt) {
  const double w = 4.0 / (s * (s + 3.0));
  const double share = w * (j + 0.5) * (1 - j * (j + 1.0) / ((s + 1.0) * (s + 2.0)));
  return {static_cast<std::uint32_t>((j - 1) % 2), static_cast<real>((j - 1.0) / (j + 2.0)),
          static_cast<real>((2 * j + 1.0) / (j + 2.0) * w * dt), static_cast<real>(share), j == s};
}

// Returns the largest dt K / m that s stages keep stable, with a margin to the end of the polynomial's range, where it
// does not damp.
inline double stage_reach(int s) { return 0.95 * 0.25 * s * (s + 3.0); }

// Returns k_ij / (V_i V_j F) of two fluids, or of a fluid and a solid.
PALP_HD inline real pair_viscosity(const Medium& medium, Tag a, Tag b) {
  if ((!a.is_fluid() && !b.is_fluid()) || a.by_geometry() || b.by_geometry()) return real(0);
  if (!a.is_fluid()) return real(4) * medium.material[b.material()].viscosity;
  const real mu = medium.material[a.material()].viscosity;
  if (!b.is_fluid()) return real(4) * mu;
  if (a.material() == b.material()) return real(2) * mu;
  const real mu_b = medium.material[b.material()].viscosity, sum = mu + mu_b;
  return sum > real(0) ? real(4) * mu * mu_b / sum : real(0);
}

// Sets Y_0 of all particles, l of those that move on their own, and K of those of rigid bodies.
struct BeginViscosity {
  ParticleView state;
  BodyViews bodies;
  CellGrid grid;
  FluidKernel kernel;
  Medium medium;
  ViscosityViews viscosity;
  real reach;  // stage_reach()

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = state.tag[i];
    const Packed xV_i = state.xV[i];
    real sum = 0;
    if (tag_i.kind() != BodyKind::fixed)
      for_neighbors(grid, state.xV, xV_i.xyz(), kernel.support, team,
                    [&](std::uint32_t j, const Packed& xV_j, const Vec3&, real r2) {
                      if (j == i) return;
                      const Tag tag_j = medium.uniform ? tag_i : state.tag[j];
                      sum += xV_j.w * kernel.F(Eigen::numext::sqrt(r2)) * pair_viscosity(medium, tag_i, tag_j);
                    });
    real K = xV_i.w * team.sum(sum);
    if (!team.leader()) return;
    if (viscosity.drag != nullptr && tag_i.is_fluid()) K += viscosity.drag[i].sum();
    real limit = 1;
    if (tag_i.kind() == BodyKind::rigid) {
      const BodyState& body = bodies.body[tag_i.body()];
      viscosity.solid[body.force_first + state.id[i] - body.first] = pack(Vec3(0, 0, 0), K);
    } else if (tag_i.kind() != BodyKind::fixed && K * medium.dt > reach * state.mass[i]) {
      limit = reach * state.mass[i] / (K * medium.dt);
    }
    viscosity.stage[0][i] = viscosity.stage[1][i] = pack(state.vp[i].xyz(), limit);
  }
};

// Sets the stages of what sleeps (sleep.h), which nothing else does: it stands still for all that is around it.
struct RestStages {
  ParticleView state;
  ViscosityViews viscosity;

  PALP_HD void operator()(std::uint32_t i) const {
    if (state.tag[i].asleep()) viscosity.stage[0][i] = viscosity.stage[1][i] = pack(Vec3(0, 0, 0), real(1));
  }
};

// Applies one stage to the particles.
struct ViscousStage {
  ParticleView state;
  BodyViews bodies;
  CellGrid grid;
  FluidKernel kernel;
  Medium medium;
  ViscosityViews viscosity;
  Packed* acceleration;  // of fluids, by all other forces; by all of them after the last stage
  StageNumbers numbers;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = state.tag[i];
    std::uint32_t k = kNone;
    if (!tag_i.is_fluid()) {
      const BodyState& body = bodies.body[tag_i.body()];
      if (body.force_first == kNone) return;
      k = body.force_first + state.id[i] - body.first;
    }
    const Packed* from = viscosity.stage[numbers.from];
    Packed* to = viscosity.stage[1 - numbers.from];
    const Packed xV_i = state.xV[i], Y_i = from[i];
    Vec3 force(0, 0, 0);
    for_neighbors(grid, state.xV, xV_i.xyz(), kernel.support, team,
                  [&](std::uint32_t j, const Packed& xV_j, const Vec3&, real r2) {
                    const Tag tag_j = medium.uniform ? tag_i : state.tag[j];
                    const Packed Y_j = fetch(from, j);
                    const real coefficient = pair_viscosity(medium, tag_i, tag_j) * min(Y_i.w, Y_j.w);
                    force -=
                        (xV_i.w * xV_j.w * kernel.F(Eigen::numext::sqrt(r2)) * coefficient) * (Y_i.xyz() - Y_j.xyz());
                  });
    force = team.sum(force);
    if (!team.leader()) return;
    if (k != kNone) {
      const Packed before = bodies.force[k];
      bodies.force[k] = pack(before.xyz() + numbers.share * force, before.w);
      if (tag_i.kind() == BodyKind::rigid) viscosity.solid[k] = pack(force, 0);
      if (tag_i.kind() != BodyKind::elastic) return;
    }
    if (viscosity.drag != nullptr && tag_i.is_fluid()) {
      const WallDrag drag = viscosity.drag[i];
      for (int n = 0; n < WallDrag::kMost; ++n) {
        if (drag.body[n] == kNone) continue;
        const std::uint32_t index = viscosity.wall[drag.body[n]];
        const BodyState& body = bodies.body[index];
        const Packed Y_b = stage_velocity(viscosity, body, index, numbers.from, drag.foot[n]);
        force -= (drag.k[n] * min(Y_i.w, Y_b.w)) * (Y_i.xyz() - Y_b.xyz());
      }
    }
    Vec3 a = force / state.mass[i];
    if (tag_i.is_fluid()) a += acceleration[i].xyz();
    const Vec3 Y = Y_i.xyz() + numbers.carry * (Y_i.xyz() - to[i].xyz()) + numbers.rate * a;
    to[i] = pack(Y, Y_i.w);
    if (numbers.last && tag_i.is_fluid()) acceleration[i] = pack((Y - state.vp[i].xyz()) / medium.dt, 0);
  }
};

// Computes Y_j of each rigid body; one team a body.
struct ViscousBodyStage {
  BodyViews bodies;
  const std::uint32_t* rigid;
  ViscosityViews viscosity;
  WallWrenches walls;
  StageNumbers numbers;

  template <class Team>
  PALP_HD void operator()(std::uint32_t k, Team team) const {
    const BodyState& body = bodies.body[rigid[k]];
    ViscousBody& b = viscosity.body[rigid[k]];
    const Mat3 R = body.q.toRotationMatrix();
    Vec3 force(0, 0, 0), torque(0, 0, 0);
    for (std::uint32_t p = body.force_first + team.lane(); p < body.force_first + body.count; p += team.size()) {
      const Vec3 f = viscosity.solid[p].xyz();
      force += f;
      torque += (R * bodies.local[p].xyz()).cross(f);
    }
    if (walls.place != nullptr && walls.place[rigid[k]] != kNone)
      for (std::uint32_t p = team.lane(); p < walls.parts; p += team.size()) {
        const WallWrench& w = viscosity.drag_wrench[p * walls.bodies + walls.place[rigid[k]]];
        force += w.force;
        torque += w.torque;
      }
    force = team.sum(force);
    torque = team.sum(torque);
    if (!team.leader()) return;
    const std::uint32_t from = numbers.from, to = 1 - from;
    Vec3 v, w;
    b.mass.solve(numbers.rate * force, numbers.rate * torque, v, w);
    const real part = numbers.rate / b.dt;
    b.v[to] = b.v[from] + numbers.carry * (b.v[from] - b.v[to]) + part * b.dv + v;
    b.w[to] = b.w[from] + numbers.carry * (b.w[from] - b.w[to]) + part * b.dw + w;
  }
};

// Writes Y of the particles of rigid bodies.
struct SpreadBodyVelocities {
  ParticleView state;
  BodyViews bodies;
  ViscosityViews viscosity;
  std::uint32_t to;

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = state.tag[i];
    if (tag.kind() != BodyKind::rigid) return;
    const BodyState& body = bodies.body[tag.body()];
    const ViscousBody& b = viscosity.body[tag.body()];
    const Vec3 r = body.q * bodies.local[body.force_first + state.id[i] - body.first].xyz();
    viscosity.stage[to][i] = pack(b.v[to] + b.w[to].cross(r), b.limit);
  }
};

}  // namespace palp
