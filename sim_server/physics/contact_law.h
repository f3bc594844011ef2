// The law of contact between two rigid or fixed bodies: points of each one's surface against the other's signed
// distance.
//
// symbol     meaning                                                                        unit
// d, n       depth of a point, outward normal where it is; v = velocity against the other   m, -, m/s
// m_i        1 / (1/m + (r x n).I^-1 (r x n)) of both bodies: effective mass along n at i    kg
// D_i        depth, averaged over the sub-step at constant velocity                         m
// N          (sum D)^2 / sum D^2 over the pair's points: the number that share the load     -
// normal     k_i D_i - c_i v.n >= 0,  k_i = kappa m_i / (N dt^2),  c_i = gamma m_i / (N dt)
// tangential -k_t s - c_t v_t, at most the friction below, s = what the point has moved since it stuck;
//            k_t = kappa_t m_t D_i / (sum D dt^2), c_t = gamma_t m_t D_i / (sum D dt), m_t as m_i, but along the force:
//            each point holds in proportion to its load and all slip at once (Cundall & Strack 1979)
// friction   mu_k N_i + exp(-(v_t / v_s)^2) (mu_s H_i - mu_k N_i), N_i the normal force: static friction falls to
//            kinetic friction as a point slips faster (Stribeck's curve: Armstrong-Helouvry, Dupont & Canudas de Wit
//            1994)
// H_i        the load that a point holds with while it hardly slips: the most of N_i, what would stop the bodies'
//            approach within the sub-step, and what it was, less a 32nd a sub-step
//
// What hardly moves, by v_s, does not bounce: gamma is as large for it as stability affords, or what was placed would
// swing for long.
//
// The spring of contact needs several sub-steps to bear a body that arrives, and swings for some more, which a rigid
// surface does not. Coulomb's law with that load lets a body slip that is placed on a slope below its angle of
// friction, and kinetic friction then never stops it again. H is the load of the surface that the spring stands for.
// What slips faster than v_s does not feel it, so that impacts keep their friction.
//
// A tool in a hand meets fixed bodies implicitly: its step (proxy.h) takes dt k_i + c_i times the change of v.n from
// the normal force, and no number of points or walls makes that unstable. Its kappa is 1, more than an explicit step
// affords: the tool enters a wall less. Its tangential stiffness is that of the explicit law; friction counts no more
// than the spring, since the damper's force ahead of that change is far too large, and H is N_i.
//
// k grows with the mass and falls with the sub-step so that k dt^2/m + 2 c dt/m keeps its share of the stability limit
// of 4, k_t and c_t likewise; dividing by N makes it independent of how many points touch. Where a body meets more than
// two others at once, N grows in proportion. kappa and gamma of a pair follow from its restitution
// (solver/constants.h). The averaged depth makes a bounce independent, to first order in kappa, of the moment within
// the sub-step at which it begins.
//
// A point remembers on which side it came near: past the middle of a thin plate its nearest surface would be the wrong
// one, and its depth is then counted on from the last sub-step.
#pragma once

#include "sim_server/physics/distance.h"
#include "sim_server/physics/rigid.h"

namespace palp {

// The speed across the normal at which static friction has fallen to kinetic friction by 1 - 1/e [m/s], but for what
// gravity adds in a sub-step.
inline constexpr real kStribeck = real(0.005);

// The share of the load it holds with that a point forgets in a sub-step. Blocks on the floor swing on their contacts
// in some twenty sub-steps.
inline constexpr real kForgets = real(1) / real(32);

struct ContactLaw {
  real friction, kinetic;   // static and kinetic coefficient
  real stiffness, damping;  // kappa, gamma
  real resting;             // gamma of what hardly moves
  real tangential, drag;    // kappa_t, gamma_t
  bool implicit;
};

struct ContactPair {
  std::uint32_t a, b;              // bodies
  std::uint32_t shape_a, shape_b;  // indices in ContactViews::shape; kNone where a is soft
  std::uint32_t first;  // index in ContactViews::state: a's points, b's points, a's rounds, b's rounds; where a is soft
                        // its particles
  ContactLaw law;
};

// A part of the particles of a soft body, in the order of its kind of matter, and the pairs in which these particles
// are body a.
struct SoftPart {
  std::uint32_t first, count;
  std::uint32_t first_pair, pairs;
  Quat lattice;  // of the cells that its particles fill, at rest; zero where they lie anyhow
};

// The memory of one point against one body, in that body's axes.
struct ContactState {
  Packed side;    // normal of the side on which the point is; its depth, -1e30: far away
  Packed anchor;  // displacement since it stuck; of rigid and frozen matter H, of elastic particles 1: it slips
};

// The distance from a body up to which a soft body's particle may come [m], negative where it was inside, and its state
// when that distance was found: 0 liquid, 1 solid, 2 not found yet.
struct ClosestApproach {
  real reach;
  std::uint32_t solid;
};

struct ElasticPush;

struct ContactViews {
  std::uint32_t elastic_parts = 0, frozen_parts = 0;
  bool elastic_on_rigid = false;  // elastic bodies may touch rigid ones, which share their mass among these contacts
  bool single_pass = false;       // no rigid body is in so many pairs that their loads have to be compared first
  const ContactPair* pair = nullptr;
  const ContactBody* shape = nullptr;
  const Piece* piece = nullptr;
  const NodeGrid* grid = nullptr;
  const SurfacePoint* point = nullptr;
  const Round* round = nullptr;
  const SoftPart* elastic_part = nullptr;
  const SoftPart* frozen_part = nullptr;
  ContactState* state = nullptr;
  std::uint32_t first_soft = 0;         // index of the first state of a soft part; arrays by soft state begin there
  ClosestApproach* near = nullptr;      // by soft state
  ElasticPush* elastic_push = nullptr;  // by soft state of elastic particles; null unless elasticity is implicit
  PairWrenches by;
};

PALP_HD inline PairWrench no_wrench() {
  return {Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0), real(0), real(1), false, real(0)};
}
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
  const Forcing* forcing;
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

  // Returns the touch of a point, which is a ball around owner.x + arm; forces act at its surface, or (solid = false)
  // in its middle.
  PALP_HD Touch touch(const Motion& owner, const Motion& field, const Vec3& arm, real radius, bool solid,
                      const Mat3& R_field, const ContactBody& shape, const Packed& side) const {
    Touch t;
    const Vec3 x = nearest_image(grid, owner.x - field.x + arm);
    const Vec3 v_field = field.fixed ? Vec3(0, 0, 0) : Vec3(field.v + field.w.cross(x));
    t.v = owner.fixed ? Vec3(-v_field) : Vec3(owner.v + owner.w.cross(arm) - v_field);
    const real moved = dt * t.v.norm();
    const Vec3 y = R_field.transpose() * x;
    t.near = false;
    t.depth = real(-1e30);
    t.mean = t.share = real(0);
    // the box around the solid spares most points the rest
    if (side.w < real(-1e29) && outside_bounds(shape, y, radius + real(2) * moved)) return t;
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

  // Returns the effective mass of both bodies along the unit vector u at the point [kg].
  PALP_HD static real moving_mass(const BodyState& owner, const BodyState& field, const Mat3& R_owner,
                                  const Mat3& R_field, const Touch& t, const Vec3& u) {
    const Vec3 a = R_owner.transpose() * t.r.cross(u), b = R_field.transpose() * t.other.cross(u);
    return real(1) / (inverse_mass(owner) + inverse_mass(field) + a.dot(owner.inverse_inertia * a) +
                      b.dot(field.inverse_inertia * b));
  }

  // The force at a point along its normal [N], the load that friction counts with [N], and the force that a unit of an
  // implicit step's change of velocity takes from it [N s/m].
  struct NormalForce {
    real push, load, resists;
  };

  // Returns 1 for a point at rest and 0 for one that is faster than the speeds of settling, v in m/s.
  PALP_HD real slowness(real v) const {
    const real falls = kStribeck + dt * forcing->gravity.norm();
    return Eigen::numext::exp(-(v * v) / (falls * falls));
  }

  PALP_HD NormalForce normal_force(const ContactLaw& law, const Touch& t, real m, real sharing) const {
    const real slow = slowness(t.v.dot(t.n)), gamma = law.damping + slow * (law.resting - law.damping);
    const real k = law.stiffness * m / (sharing * dt * dt), c = gamma * m / (sharing * dt);
    const real spring = k * t.mean, push = spring - c * t.share * t.v.dot(t.n);
    if (!(push > real(0))) return {real(0), real(0), real(0)};
    return {push, law.implicit && spring < push ? spring : push, law.implicit ? t.share * (dt * k + c) : real(0)};
  }

  // Returns the load with which a point that hardly slips holds [N]. before: what it was in the last sub-step; mass: of
  // both bodies, reduced [kg].
  PALP_HD real holding(const ContactLaw& law, const Touch& t, const NormalForce& normal, real part, real mass,
                       real before) const {
    if (law.implicit) return normal.load;
    const real stops = -part * mass * t.v.dot(t.n) / dt, fading = (real(1) - kForgets) * before;
    const real most = stops > fading ? stops : fading;
    return most > normal.load ? most : normal.load;
  }

  // Returns normal and tangential force. part: the share of the pair's load that this point bears; mass: of both
  // bodies, reduced; mass_along(u): their effective mass along a unit vector at the point [kg].
  template <class MassAlong>
  PALP_HD Vec3 force(const ContactLaw& law, const Touch& t, const NormalForce& normal, real part, real mass,
                     const MassAlong& mass_along, const Mat3& R_field, ContactState& state) const {
    if (!(law.friction > real(0))) return normal.push * t.n;
    const Vec3 v_t = t.v - t.v.dot(t.n) * t.n;
    Vec3 s = R_field * state.anchor.xyz() + dt * v_t;
    s -= s.dot(t.n) * t.n;
    const Vec3 held = law.tangential * s + law.drag * dt * v_t;
    const real size = held.norm();
    const real load = holding(law, t, normal, part, mass, state.anchor.w);
    Vec3 f(0, 0, 0);
    if (size > real(0)) {
      const real m = part * mass_along(Vec3(held / size)) / (dt * dt);
      const real slides = law.kinetic * normal.load;
      const real most = slides + slowness(v_t.norm()) * (law.friction * load - slides);
      f = -m * held;
      if (m * size > most) {
        f *= most / (m * size);
        s = -f / (law.tangential * m);
      }
    }
    state.anchor = pack(R_field.transpose() * s, load);
    return normal.push * t.n + f;
  }

  // Returns whether nothing of a pair can touch in this sub-step. In a period a body's bounds have images beyond the
  // nearest centre, so only the balls around the bodies count there.
  PALP_HD bool far(const ContactPair& pair) const {
    const BodyState &a = body[pair.a], &b = body[pair.b];
    const ContactBody &shape_a = contact.shape[pair.shape_a], &shape_b = contact.shape[pair.shape_b];
    const real speed = (a.v - b.v).norm() + a.w.norm() * shape_a.reach + b.w.norm() * shape_b.reach;
    const real both = shape_a.reach + shape_b.reach, margin = real(3) * dt * speed + real(0.01) * both;
    const Vec3 x = nearest_image(grid, b.x - a.x);
    if (x.norm() > both + margin) return true;
    if (grid.periodic(0) || grid.periodic(1) || grid.periodic(2)) return false;
    const Mat3 R_a = a.q.toRotationMatrix(), R_b = b.q.toRotationMatrix();
    return bounds_apart(shape_a, R_a, shape_b, R_b, x, margin) || bounds_apart(shape_b, R_b, shape_a, R_a, -x, margin);
  }

  // One side of a pair against the other's distance field.
  struct Side {
    const BodyState &owner, &field;
    const ContactBody &of_owner, &of_field;
    const Mat3 &R_owner, &R_field;
  };

  // Returns the side whose owner is a (mine), or b.
  PALP_HD Side side_of(const ContactPair& pair, const Mat3& R_a, const Mat3& R_b, bool mine) const {
    const BodyState &a = body[pair.a], &b = body[pair.b];
    const ContactBody &shape_a = contact.shape[pair.shape_a], &shape_b = contact.shape[pair.shape_b];
    return mine ? Side{a, b, shape_a, shape_b, R_a, R_b} : Side{b, a, shape_b, shape_a, R_b, R_a};
  }

  PALP_HD Touch touch(const Side& s, const Vec3& place, real radius, const ContactState& state) const {
    return touch(motion_of(s.owner), motion_of(s.field), s.R_owner * place, radius, true, s.R_field, s.of_field,
                 state.side);
  }

  // Returns the touch of the ball around a round, which says where the round comes nearest.
  PALP_HD Touch round_touch(const Side& s, const Round& round, const ContactState& state) const {
    const real turns = real(2) * dt * s.owner.w.norm() * round.reach;
    return touch(s, round.center, round.reach + turns, state);
  }

  // The states of the rounds of a pair's side; indices are those of ContactViews::round.
  PALP_HD ContactState& round_state(const ContactPair& pair, const Side& s, bool mine, std::uint32_t round) const {
    const std::uint32_t before = mine ? 0 : contact.shape[pair.shape_a].rounds;
    return contact.state[pair.first + points(pair) + before + round - s.of_owner.first_round];
  }

  PALP_HD Touch touch(const ContactPair& pair, const Mat3& R_a, const Mat3& R_b, std::uint32_t p) const {
    const std::uint32_t of_a = contact.shape[pair.shape_a].points;
    const bool mine = p < of_a;
    const Side s = side_of(pair, R_a, R_b, mine);
    const SurfacePoint point = contact.point[s.of_owner.first_point + (mine ? p : p - of_a)];
    const ContactState& state = contact.state[pair.first + p];
    if (point.round == kNone) return touch(s, point.ball.xyz(), point.ball.w, state);
    const Round& round = contact.round[point.round];
    const Touch all = round_touch(s, round, round_state(pair, s, mine, point.round));
    if (!all.near) return all;
    const Vec3 n = s.R_owner.transpose() * all.n, place = counted_from(round, n, point.ball.xyz());
    // the one that faces the other solid from the middle; others find their own way, as to a second wall of a corner
    Vec3 nearest = nearest_in_sector(round, n, place);
    Touch t = touch(s, nearest, point.ball.w, state);
    if (t.depth < -round.reach) return t;
    if (nearest == place) {
      nearest = nearest_in_sector(round, s.R_owner.transpose() * t.n, place);
      if (nearest != place) t = touch(s, nearest, point.ball.w, state);
    }
    if (!t.near) return t;
    // a place that moves in its sector comes no nearer by the body's spin
    const Vec3 axis = s.R_owner * round.axis, spin = s.owner.w.dot(axis) * axis;
    t.v -= spin.cross(t.r - s.R_owner * round.center).dot(t.n) * t.n;
    set_depth(t, t.depth);
    return t;
  }

  // Remembers on which side the rounds of a pair are; k: one of them, a's first.
  PALP_HD void remember_round(const ContactPair& pair, const Mat3& R_a, const Mat3& R_b, std::uint32_t k) const {
    const std::uint32_t of_a = contact.shape[pair.shape_a].rounds;
    const bool mine = k < of_a;
    const Side s = side_of(pair, R_a, R_b, mine);
    const std::uint32_t round = s.of_owner.first_round + (mine ? k : k - of_a);
    ContactState& state = round_state(pair, s, mine, round);
    const Touch t = round_touch(s, contact.round[round], state);
    if (t.near)
      state.side = pack(s.R_field.transpose() * t.n, t.depth);
    else
      state = no_contact();
  }

  PALP_HD std::uint32_t rounds(const ContactPair& pair) const {
    return contact.shape[pair.shape_a].rounds + contact.shape[pair.shape_b].rounds;
  }

  PALP_HD std::uint32_t points(const ContactPair& pair) const {
    return contact.shape[pair.shape_a].points + contact.shape[pair.shape_b].points;
  }
};

}  // namespace palp
