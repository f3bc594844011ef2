// Contact between two rigid or fixed bodies: points of each one's surface against the other's signed distance.
//
// symbol     meaning                                                                        unit
// d, n       depth of a point, outward normal where it is; v = velocity against the other   m, -, m/s
// m_i        1 / (1/m + (r x n).I^-1 (r x n)) of both bodies: effective mass along n at i    kg
// D_i        depth, averaged over the sub-step at constant velocity                         m
// N          (sum D)^2 / sum D^2 over the pair's points: the number that share the load     -
// normal     k_i D_i - c_i v.n >= 0,  k_i = kappa m_i / (N dt^2),  c_i = gamma m_i / (N dt)
// tangential -k_t s - c_t v_t, at most mu times the normal force, s = what the point has moved since it stuck;
//            k_t = 2/7 k N D_i / sum D (Cundall & Strack 1979), so that each point holds in proportion to its load
//            and all slip at once; static friction acts until a point slips, kinetic friction while it slips
//
// A tool in a hand meets fixed bodies implicitly: its step (proxy.h) takes dt k_i + c_i times the change of v.n from
// the normal force, and no number of points or walls makes that unstable. Its kappa is 1, more than an explicit step
// affords: the tool enters a wall less. Its tangential stiffness is that of the explicit law; friction counts no more
// than the spring, since the damper's force ahead of that change is far too large.
//
// k grows with the mass and falls with the sub-step so that k dt^2/m + 2 c dt/m keeps its share of the stability limit
// of 4; dividing by N makes it independent of how many points touch. Where a body meets more than two others at once, N
// grows in proportion. kappa and gamma of a pair follow from its restitution (solver/constants.h). The averaged depth
// makes a bounce independent, to first order in kappa, of the moment within the sub-step at which it begins.
//
// A point remembers on which side it came near: past the middle of a thin plate its nearest surface would be the wrong
// one, and its depth is then counted on from the last sub-step.
#pragma once

#include "sim_server/physics/distance.h"
#include "sim_server/physics/rigid.h"

namespace palp {

struct ContactLaw {
  real friction, kinetic;   // static and kinetic coefficient
  real stiffness, damping;  // kappa, gamma
  real tangential;          // kappa of the tangential spring
  bool implicit;
};

struct ContactPair {
  std::uint32_t a, b;              // bodies
  std::uint32_t shape_a, shape_b;  // indices in ContactViews::shape; kNone where a is soft
  std::uint32_t first;             // index in ContactViews::state: a's points, then b's; where a is soft its particles
  ContactLaw law;
};

// A part of the particles of a soft body, in the order of its kind of matter, and the pairs in which these particles
// are body a.
struct SoftPart {
  std::uint32_t first, count;
  std::uint32_t first_pair, pairs;
};

// The memory of one point against one body, in that body's axes.
struct ContactState {
  Packed side;    // normal of the side on which the point is; its depth, -1e30: far away
  Packed anchor;  // displacement since it stuck; 1: it slips
};

// The distance from a body up to which a particle that changes state may come [m], negative where it was inside, and
// its state when that distance was found: 0 liquid, 1 solid, 2 not found yet.
struct ClosestApproach {
  real reach;
  std::uint32_t solid;
};

struct ContactViews {
  std::uint32_t pairs = 0;  // pairs of rigid and fixed bodies; those of soft parts follow
  std::uint32_t elastic_parts = 0, frozen_parts = 0;
  bool single_pass = false;  // no rigid body is in so many pairs that their loads have to be compared first
  const ContactPair* pair = nullptr;
  const ContactBody* shape = nullptr;
  const Piece* piece = nullptr;
  const NodeGrid* grid = nullptr;
  const Packed* point = nullptr;  // about the centre of mass, body axes; radius of the ball around it
  const SoftPart* elastic_part = nullptr;
  const SoftPart* frozen_part = nullptr;
  ContactState* state = nullptr;
  ClosestApproach* near = nullptr;  // FrozenMatter::near
  std::uint32_t first_frozen = 0;
  PairWrenches by;
};

PALP_HD inline PairWrench no_wrench() { return {Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0), real(0), real(1), false}; }
PALP_HD inline ContactState no_contact() { return {{0, 0, 0, real(-1e30)}, {0, 0, 0, 0}}; }

// Returns the mean of max(0, depth) over a sub-step in which the depth grows at a constant rate and is `depth` in the
// middle. half: the change of depth in half a sub-step.
template <class S>
PALP_HD inline S mean_depth(S depth, S half) {
  if (depth >= half) return depth > S(0) ? depth : S(0);
  if (!(depth > -half)) return S(0);
  return (depth + half) * (depth + half) / (S(4) * half);
}

// Returns the share of the sub-step in which the point is inside.
template <class S>
PALP_HD inline S share_inside(S depth, S half) {
  if (depth >= half) return S(1);
  return depth > -half ? (depth + half) / (S(2) * half) : S(0);
}

// The motion of a body, or of a particle, as a whole.
struct Motion {
  Vec3 x, v, w;
  bool fixed;  // its velocity is that of its surface, which stays in place
};

PALP_HD inline Motion motion_of(const BodyState& b) { return {b.x, b.v, b.w, b.kind == BodyKind::fixed}; }

// The inputs and functions that all passes over contact points share.
struct PairPoints {
  ContactViews contact;
  const BodyState* body;
  CellGrid grid;  // for its periods
  real dt;

  // The state of one point of `owner` against the distance field of `field`.
  struct Touch {
    Vec3 n, v;      // normal; velocity of the owner against the field's body; world axes
    Vec3 r, other;  // place of the point from the owner's and from the field's centre
    real depth, mean, share;
    bool near;
  };

  PALP_HD static real inverse_mass(const BodyState& b) {
    return b.kind == BodyKind::rigid ? real(1) / b.mass : real(0);
  }

  PALP_HD Vec3 nearest_image(Vec3 d) const {
    for (int a = 0; a < 3; ++a)
      if (grid.periodic(a)) d[a] -= grid.period[a] * Eigen::numext::floor(d[a] / grid.period[a] + real(0.5));
    return d;
  }

  // Returns the touch of a point, which is a ball around owner.x + arm; forces act at its surface, or (solid = false)
  // in its middle.
  PALP_HD Touch touch(const Motion& owner, const Motion& field, const Vec3& arm, real radius, bool solid,
                      const Mat3& R_field, const ContactBody& shape, const Packed& side) const {
    Touch t;
    const Vec3 x = nearest_image(owner.x - field.x + arm);
    const Vec3 v_field = field.fixed ? Vec3(0, 0, 0) : Vec3(field.v + field.w.cross(x));
    t.v = owner.fixed ? Vec3(-v_field) : Vec3(owner.v + owner.w.cross(arm) - v_field);
    const real moved = dt * t.v.norm();
    const Vec3 y = R_field.transpose() * x;
    t.near = false;
    t.depth = real(-1e30);
    t.mean = t.share = real(0);
    // the box around the solid spares most points the rest
    const Vec3 z = shape.R.transpose() * (y - shape.c);
    const real margin = radius + real(2) * moved;
    if (side.w < real(-1e29))
      for (int a = 0; a < 3; ++a)
        if (z[a] < shape.low[a] - margin || z[a] > shape.high[a] + margin) return t;
    const Distance now = solid_distance(shape, contact.piece, contact.grid, y);
    t.depth = radius - now.d;
    t.n = R_field * now.n;
    if (side.w > real(-1e29) && now.n.dot(side.xyz()) < real(-0.5)) {
      t.n = R_field * side.xyz();
      t.depth = side.w - dt * t.v.dot(t.n);
    }
    t.near = t.depth > real(-2) * moved;
    if (!t.near) return t;
    const real lever = solid ? radius : real(0);
    t.r = arm - lever * t.n;
    t.other = x - lever * t.n;
    t.v = owner.v + owner.w.cross(t.r) - field.v - (field.fixed ? Vec3(0, 0, 0) : Vec3(field.w.cross(t.other)));
    if (field.fixed) t.v += field.v.dot(t.n) * t.n;
    if (owner.fixed) t.v -= owner.v.dot(t.n) * t.n;
    set_depth(t, t.depth);
    return t;
  }

  PALP_HD void set_depth(Touch& t, real depth) const {
    const real half = real(0.5) * dt * Eigen::numext::abs(t.v.dot(t.n));
    t.depth = depth;
    t.mean = mean_depth(depth, half);
    t.share = share_inside(depth, half);
  }

  // Returns the effective mass of both bodies along n at the point [kg].
  PALP_HD static real moving_mass(const BodyState& owner, const BodyState& field, const Mat3& R_owner,
                                  const Mat3& R_field, const Touch& t) {
    const Vec3 a = R_owner.transpose() * t.r.cross(t.n), b = R_field.transpose() * t.other.cross(t.n);
    return real(1) / (inverse_mass(owner) + inverse_mass(field) + a.dot(owner.inverse_inertia * a) +
                      b.dot(field.inverse_inertia * b));
  }

  // The force at a point along its normal [N], the load that friction counts with [N], and the force that a unit of an
  // implicit step's change of velocity takes from it [N s/m].
  struct NormalForce {
    real push, load, resists;
  };

  PALP_HD NormalForce normal_force(const ContactLaw& law, const Touch& t, real m, real sharing) const {
    const real k = law.stiffness * m / (sharing * dt * dt), c = law.damping * m / (sharing * dt);
    const real spring = k * t.mean, push = spring - c * t.share * t.v.dot(t.n);
    if (!(push > real(0))) return {real(0), real(0), real(0)};
    return {push, law.implicit && spring < push ? spring : push, law.implicit ? t.share * (dt * k + c) : real(0)};
  }

  // Returns normal and tangential force. part: the share of the pair's load that this point bears.
  PALP_HD Vec3 force(const ContactLaw& law, const Touch& t, real m, const NormalForce& normal, real part,
                     const Mat3& R_field, ContactState& state) const {
    if (!(law.friction > real(0))) return normal.push * t.n;
    const Vec3 v_t = t.v - t.v.dot(t.n) * t.n;
    Vec3 s = R_field * state.anchor.xyz() + dt * v_t;
    s -= s.dot(t.n) * t.n;
    const real k_t = real(2) / real(7) * law.tangential * m * part / (dt * dt);
    const real c_t = real(0.6) * Eigen::numext::sqrt(k_t * m * part);
    Vec3 f = -k_t * s - c_t * v_t;
    const real size = f.norm(), holds = (state.anchor.w > real(0) ? law.kinetic : law.friction) * normal.load;
    real slips = 0;
    if (size > holds) {
      f *= law.kinetic * normal.load / size;
      s = -f / k_t;
      slips = 1;
    }
    state.anchor = pack(R_field.transpose() * s, slips);
    return normal.push * t.n + f;
  }

  PALP_HD bool far(const ContactPair& pair) const {
    const BodyState &a = body[pair.a], &b = body[pair.b];
    const real reach_a = contact.shape[pair.shape_a].reach, reach_b = contact.shape[pair.shape_b].reach;
    const real speed = (a.v - b.v).norm() + a.w.norm() * reach_a + b.w.norm() * reach_b;
    return nearest_image(a.x - b.x).norm() > reach_a + reach_b + real(3) * dt * speed;
  }

  PALP_HD Touch touch(const ContactPair& pair, const Mat3& R_a, const Mat3& R_b, std::uint32_t p) const {
    const BodyState &a = body[pair.a], &b = body[pair.b];
    const ContactBody &shape_a = contact.shape[pair.shape_a], &shape_b = contact.shape[pair.shape_b];
    const Packed side = contact.state[pair.first + p].side;
    const bool mine = p < shape_a.points;
    const Packed point = contact.point[mine ? shape_a.first_point + p : shape_b.first_point + p - shape_a.points];
    return touch(motion_of(mine ? a : b), motion_of(mine ? b : a), (mine ? R_a : R_b) * point.xyz(), point.w, true,
                 mine ? R_b : R_a, mine ? shape_b : shape_a, side);
  }

  PALP_HD std::uint32_t points(const ContactPair& pair) const {
    return contact.shape[pair.shape_a].points + contact.shape[pair.shape_b].points;
  }
};

// The mean depth of a pair of bodies in one another, and the number of points that share it.
struct PairLoad {
  real depth, sharing;
  bool near;
};

// Measures the load of a pair; forgets the memory of its points when the two bodies are far apart. All of a team take
// part and get the answer.
template <class Team>
PALP_HD PairLoad load_of(const PairPoints& all, std::uint32_t index, Team team) {
  const ContactPair pair = all.contact.pair[index];
  const std::uint32_t points = all.points(pair);
  Vec3 sums(0, 0, 0);
  const bool far = all.far(pair), used = all.contact.by.wrench[index].near;
  if (far && used)
    for (std::uint32_t p = team.lane(); p < points; p += team.size()) all.contact.state[pair.first + p] = no_contact();
  if (!far) {
    const Mat3 R_a = all.body[pair.a].q.toRotationMatrix(), R_b = all.body[pair.b].q.toRotationMatrix();
    for (std::uint32_t p = team.lane(); p < points; p += team.size()) {
      const real mean = all.touch(pair, R_a, R_b, p).mean;
      sums += Vec3(mean, mean * mean, 0);
    }
  }
  sums = team.sum(sums);  // by now all have read whether it was near
  if (far) return {real(0), real(1), false};
  if (!(sums[1] > real(0))) return {real(0), real(1), true};
  return {sums[1] / sums[0], sums[0] * sums[0] / sums[1], true};
}

// Measures the loads of all pairs before RigidContact, where bodies are in many pairs; one team a pair.
struct MeasureContact {
  PairPoints all;

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const PairLoad load = load_of(all, index, team);
    if (!team.leader()) return;
    PairWrench out = no_wrench();
    out.depth = load.depth;
    out.sharing = load.sharing;
    out.near = load.near;
    all.contact.by.wrench[index] = out;
  }
};

// Computes the forces of each pair of rigid and fixed bodies and updates the memory of its points; one team a pair.
struct RigidContact {
  PairPoints all;

  // Returns the number of pairs that share a body's load over the two that the stability limit has room for, at
  // least 1.
  PALP_HD real load_sharing(std::uint32_t index) const {
    if (all.body[index].kind != BodyKind::rigid) return real(1);
    const PairWrenches& by = all.contact.by;
    real sum = 0, sum2 = 0;
    for (std::uint32_t p = by.of_body[index]; p < by.of_body[index + 1]; ++p) {
      const real depth = by.wrench[by.part[p] / 2].depth;
      sum += depth;
      sum2 += depth * depth;
    }
    return sum * sum > real(2) * sum2 ? sum * sum / (real(2) * sum2) : real(1);
  }

  // Adds a point's resistance. n points onto the held body; r leads from its centre to the point.
  PALP_HD static void add_resistance(Resistance& to, const Vec3& n, const Vec3& r,
                                     const PairPoints::NormalForce& normal) {
    const Vec3 turn = r.cross(n);
    to.vv += normal.resists * n * n.transpose();
    to.vw += normal.resists * n * turn.transpose();
    to.ww += normal.resists * turn * turn.transpose();
    to.push += normal.push * n;
    to.turn += normal.push * turn;
  }

  template <class Team>
  PALP_HD void put_resistance(Resistance of, std::uint32_t index, bool touches, Team team) const {
    if (touches) {
      for (int c = 0; c < 3; ++c) {
        of.vv.col(c) = team.sum(Vec3(of.vv.col(c)));
        of.vw.col(c) = team.sum(Vec3(of.vw.col(c)));
        of.ww.col(c) = team.sum(Vec3(of.ww.col(c)));
      }
      of.push = team.sum(of.push);
      of.turn = team.sum(of.turn);
    }
    if (team.leader()) all.contact.by.resistance[all.contact.by.held[index]] = of;
  }

  template <class Team>
  PALP_HD PairLoad shared_load(std::uint32_t index, const ContactPair& pair, Team team) const {
    if (all.contact.single_pass) return load_of(all, index, team);
    const PairWrench& measured = all.contact.by.wrench[index];
    PairLoad load{measured.depth, measured.sharing, measured.near};
    if (load.depth > real(0)) {
      const real sharing_a = load_sharing(pair.a), sharing_b = load_sharing(pair.b);
      load.sharing *= sharing_a > sharing_b ? sharing_a : sharing_b;
    }
    return load;
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const ContactPair pair = all.contact.pair[index];
    const PairLoad load = shared_load(index, pair, team);
    PairWrench& out = all.contact.by.wrench[index];
    if (!load.near) {
      if (all.contact.single_pass && team.leader()) out = no_wrench();
      return;
    }
    const std::uint32_t points = all.points(pair), of_a = all.contact.shape[pair.shape_a].points;
    const BodyState &a = all.body[pair.a], &b = all.body[pair.b];
    const Mat3 R_a = a.q.toRotationMatrix(), R_b = b.q.toRotationMatrix();
    const bool held_a = a.proxy >= 0;  // or b is, where the law is implicit
    Vec3 force_a(0, 0, 0), torque_a(0, 0, 0), torque_b(0, 0, 0);
    Resistance resists = no_resistance();
    for (std::uint32_t p = team.lane(); p < points; p += team.size()) {
      ContactState& state = all.contact.state[pair.first + p];
      const PairPoints::Touch t = all.touch(pair, R_a, R_b, p);
      if (!t.near) {
        if (state.side.w > real(-1e29)) state = no_contact();
        continue;
      }
      const bool mine = p < of_a;
      const BodyState &owner = mine ? a : b, &field = mine ? b : a;
      const Mat3 &R_owner = mine ? R_a : R_b, &R_field = mine ? R_b : R_a;
      state.side = pack(R_field.transpose() * t.n, t.depth);
      if (!(t.mean > real(0))) {
        state.anchor = {0, 0, 0, 0};
        continue;
      }
      const real m = PairPoints::moving_mass(owner, field, R_owner, R_field, t);
      const PairPoints::NormalForce normal = all.normal_force(pair.law, t, m, load.sharing);
      const Vec3 f = all.force(pair.law, t, m, normal, t.mean / (load.sharing * load.depth), R_field, state);
      if (pair.law.implicit)
        add_resistance(resists, mine == held_a ? t.n : Vec3(-t.n), mine == held_a ? t.r : t.other, normal);
      const Vec3 on_a = mine ? f : Vec3(-f);
      force_a += on_a;
      torque_a += (mine ? t.r : t.other).cross(on_a);
      torque_b -= (mine ? t.other : t.r).cross(on_a);
    }
    force_a = team.sum(force_a);
    torque_a = team.sum(torque_a);
    torque_b = team.sum(torque_b);
    if (pair.law.implicit) put_resistance(resists, index, load.depth > real(0), team);
    // the depth stays as it was measured: other pairs may still compare theirs with it
    if (!team.leader()) return;
    out.force = force_a;
    out.torque_a = torque_a;
    out.torque_b = torque_b;
    out.near = true;
  }
};

}  // namespace palp
