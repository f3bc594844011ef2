// Rigid bodies: sets of particles that move as one (paper 3.1). Each receives, particle by particle, the opposite of
// the forces that it exerts on fluids, and a contact force from other solids.
//
// symbol     meaning                                               unit
// x, q       centre of mass; orientation (body to world)           m, -
// v, L, w    velocity; angular momentum; angular velocity, world   m/s, kg m^2/s, rad/s
// I0         inertia about the centre of mass, body axes           kg m^2
#pragma once

#include "sim_server/physics/boundary.h"
#include "sim_server/physics/outside.h"
#include "sim_server/physics/rotation.h"

namespace palp {

struct BodyState {
  Vec3 x, v, L, w;
  Quat q;
  Mat3 inertia, inverse_inertia;  // I0 and its inverse
  real mass;
  BodyKind kind;
  std::uint32_t first, count;  // particles, in the scene's order
  std::uint32_t force_first;   // index of its first particle in BodyViews::force and local, kNone: its wrench is not
                               // asked for
  std::int32_t proxy;          // index of the proxy whose handle it is, -1: none
  Vec3 handle;                 // coupling point relative to the centre of mass, body axes [m]
  real contact_mass;           // a contact's share of the mass, which sets the contact's stiffness [kg]
  std::uint32_t group;         // bodies of one group are bonded: no contact among them
  bool shaped;                 // it has a distance field
  Vec3 force, torque;          // wrench of this sub-step, about the centre of mass [N, N m]
  Vec3 force_sum, torque_sum;  // sums over the sub-steps of this haptic step [N, N m]
  Vec3 coupling_sum;           // sum of the coupling's force on the proxy over the same sub-steps [N]
  real work[2];                // work of the proxy on the coupling in this haptic step: linear, angular [J]
};

struct BodyViews {
  BodyState* body = nullptr;  // one per body of the scene, fluids included (unused)
  Packed* force = nullptr;    // per particle of bodies whose wrench is asked for; null where nothing acts on any [N]
  Packed* local = nullptr;    // position of the same particles relative to the centre of mass, body axes [m]
};

// The wrenches of contact by distance fields on a pair of bodies (rigid_contact.h).
struct PairWrench {
  Vec3 force, torque_a, torque_b;  // force on a by b; torque on a about a's centre; torque on b about b's centre
  real depth, sharing;             // sum D^2 / sum D of this sub-step; N
  bool near;                       // true: a state of the pair may be in use
  real contacts;                   // particles of an elastic body a that touch b (elastic_contact.h)
};

// The resistance of contact to a change of a body's motion within a sub-step, about its centre of mass, world axes:
// force falls by vv dv + vw dw, torque by vw^T dv + ww dw. push, turn: force and torque of the normal forces before
// that.
struct Resistance {
  Mat3 vv, vw, ww;  // [N s/m, N s, N m s]
  Vec3 push, turn;  // [N, N m]
};

PALP_HD inline Resistance no_resistance() {
  return {Mat3::Zero(), Mat3::Zero(), Mat3::Zero(), Vec3(0, 0, 0), Vec3(0, 0, 0)};
}

// The wrenches of all pairs, and the list of each body's pairs; null without such contact. Pairs of rigid and fixed
// bodies come first, then those of soft bodies' parts, also in each body's list.
struct PairWrenches {
  std::uint32_t rigid_pairs = 0;  // of rigid and fixed bodies
  PairWrench* wrench = nullptr;
  Resistance* resistance = nullptr;        // of each pair of a proxy and a fixed body
  const std::uint32_t* held = nullptr;     // by rigid pair: index in resistance, kNone
  const std::uint32_t* of_body = nullptr;  // [bodies + 1] by body: index of its first entry in part
  const std::uint32_t* part = nullptr;     // pair * 2, and 1 more where the body is b
};

// The push of some fluid particles on a body that keeps them out, and its torque about the body's centre.
struct WallWrench {
  Vec3 force, torque;
};

// The pushes on all bodies that keep fluids out (walls.h); null without any.
struct WallWrenches {
  std::uint32_t parts = 0, bodies = 0;   // of the fluid; that keep it out
  const std::uint32_t* place = nullptr;  // by body of the scene: its place among those, kNone
  WallWrench* wrench = nullptr;          // by part, and in it by place
};

// Returns true when contact of two bodies is by the distance field of one of them: then no springs act between their
// particles.
PALP_HD inline bool meet_by_field(const BodyState& a, const BodyState& b) {
  return (a.shaped && (b.shaped || b.kind == BodyKind::elastic)) || (b.shaped && a.kind == BodyKind::elastic);
}

// Returns the contact force between particles of solids that no distance field serves (elastic bodies among each other,
// bodies of loose particles): a spring between particles closer than a spacing, damped, as stiff as the lighter body's
// mass allows with this sub-step when all the contacts act that contact_mass reckons with: spring and damper then use k
// dt^2/m + 2 b dt/m = 0.7 of the linear stability limit of 4, twice that between two bodies. Frictionless.
PALP_HD inline Vec3 contact_pair_force(const Medium& medium, const BodyState& a, const BodyState& b, const Vec3& v_ij,
                                       const Vec3& x_ij, real r2) {
  const real r = Eigen::numext::sqrt(r2);
  const real overlap = medium.spacing - r;
  if (!(overlap > real(0)) || !(r > real(0)) || a.group == b.group || meet_by_field(a, b)) return Vec3(0, 0, 0);
  const real m = a.contact_mass < b.contact_mass ? a.contact_mass : b.contact_mass;
  const real k = real(0.4) * m / (medium.dt * medium.dt);
  const real damping = real(0.15) * m / medium.dt;
  const Vec3 n = x_ij / r;
  const real push = k * overlap - damping * v_ij.dot(n);
  return push > real(0) ? Vec3(push * n) : Vec3(0, 0, 0);
}

// Computes the force on each particle of the bodies whose wrench is asked for.
template <class Bonds>
struct SolidForce {
  ParticleView state;
  const Packed* wall;  // null without fluid
  BodyViews bodies;
  CellGrid grid;
  FluidKernel kernel;
  Medium medium;
  bool contact;
  Bonds bonds;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = state.tag[i];
    if (tag_i.is_fluid()) return;
    const BodyState& body = bodies.body[tag_i.body()];
    if (body.force_first == kNone) return;
    const Packed xV_i = state.xV[i], vp_i = state.vp[i];
    const auto solid_i = bonds.solid(state, i);
    Vec3 force(0, 0, 0);
    for_neighbors(
        grid, state.xV, xV_i.xyz(), kernel.support, team,
        [&](std::uint32_t j, const Packed& xV_j, const Vec3& x_ij, real r2) {
          const Tag tag_j = state.tag[j];
          const Packed vp_j = fetch(state.vp, j);
          if (tag_j.is_fluid() && !tag_i.by_geometry())
            force -= bonds.share(tag_i, solid_i, tag_j, bonds.solid(state, j)) *
                     wall_pair_force(medium, kernel, tag_j, xV_j, vp_j, xV_i.w, vp_i, wall[i], Vec3(-x_ij), r2);
          else if (contact && !tag_j.is_fluid() && tag_j.body() != tag_i.body())
            force += contact_pair_force(medium, body, bodies.body[tag_j.body()], vp_i.xyz() - vp_j.xyz(), x_ij, r2);
        });
    force = team.sum(force);
    if (team.leader()) bodies.force[body.force_first + state.id[i] - body.first] = pack(force, 0);
  }
};

// Adds up a body's forces and torques, of its particles, of contact and of fluids that it keeps out, in a fixed order;
// one team a body of the list. An elastic body that sleeps (elastic_sleep.h) keeps its wrench, as its particles keep
// their forces.
struct ReduceWrench {
  BodyViews bodies;
  PairWrenches contact;
  const std::uint32_t* reactive;  // bodies whose wrench is asked for
  WallWrenches walls;
  const Tag* sleepers;  // of elastic particles, in the order of forces; null: all are awake

  template <class Team>
  PALP_HD void operator()(std::uint32_t k, Team team) const {
    const std::uint32_t index = reactive[k];
    BodyState& body = bodies.body[index];
    if (sleepers != nullptr && body.kind == BodyKind::elastic && sleepers[body.force_first].asleep()) {
      if (!team.leader()) return;
      body.force_sum += body.force;
      body.torque_sum += body.torque;
      return;
    }
    const Mat3 R = body.q.toRotationMatrix();
    Vec3 force(0, 0, 0), torque(0, 0, 0);
    const std::uint32_t particles = bodies.force != nullptr ? body.count : 0;
    for (std::uint32_t p = body.force_first + team.lane(); p < body.force_first + particles; p += team.size()) {
      const Vec3 f = bodies.force[p].xyz();
      force += f;
      torque += (R * bodies.local[p].xyz()).cross(f);
    }
    if (contact.wrench != nullptr)
      for (std::uint32_t p = contact.of_body[index] + team.lane(); p < contact.of_body[index + 1]; p += team.size()) {
        const PairWrench& w = contact.wrench[contact.part[p] / 2];
        const bool second = (contact.part[p] & 1u) != 0;
        force += second ? Vec3(-w.force) : w.force;
        torque += second ? w.torque_b : w.torque_a;
      }
    if (walls.place != nullptr && walls.place[index] != kNone)
      for (std::uint32_t p = team.lane(); p < walls.parts; p += team.size()) {
        const WallWrench& w = walls.wrench[p * walls.bodies + walls.place[index]];
        force += w.force;
        torque += w.torque;
      }
    force = team.sum(force);
    torque = team.sum(torque);
    if (!team.leader()) return;
    body.force = force;
    body.torque = torque;
    body.force_sum += force;
    body.torque_sum += torque;
  }
};

// Returns [a], with [a] b = a x b.
PALP_HD inline Mat3 cross_matrix(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

// A body's mass and inertia, with all that resists its motion, as the linear problem of the velocities v and w that
// momenta p and l give it: A v + C w = p, C^T v + D w = l.
struct CoupledMass {
  Mat3 light;    // A^-1 [1/kg]
  Mat3 ties;     // C [kg m]
  Mat3 inverse;  // (D - C^T A^-1 C)^-1 [1/(kg m^2)]
  PALP_HD void solve(const Vec3& p, const Vec3& l, Vec3& v, Vec3& w) const {
    const Vec3 free = light * p;
    w = inverse * (l - ties.transpose() * free);
    v = free - light * (ties * w);
  }
};

// Returns the coupled mass of a body with a damper k at r from its centre, another one, k_r, on its rotation, and
// contact. With v_r = v - [r] w:
// m v + k v_r + dt (vv v + vw w) = p, I w + k_r w + r x (k v_r) + dt (vw^T v + ww w) = l. inertia, r: world axes [m].
PALP_HD inline CoupledMass coupled_mass(real mass, const Mat3& inertia, const Vec3& r, real damper, real turn_damper,
                                        const Resistance& contact, real dt) {
  const Mat3 R = cross_matrix(r), vv = dt * contact.vv, vw = dt * contact.vw;
  CoupledMass m;
  m.light = ((mass + damper) * Mat3::Identity() + vv).inverse();
  m.ties = vw - damper * R;
  // k [r] A^-1 k [r] and k [r] [r] nearly cancel where k is large; their difference is k [r] A^-1 (m + vv) [r]
  const Mat3 turned = damper * R * m.light * vw;
  const Mat3 left = inertia + turn_damper * Mat3::Identity() + dt * contact.ww - turned - turned.transpose() -
                    damper * R * m.light * (mass * Mat3::Identity() + vv) * R - vw.transpose() * m.light * vw;
  m.inverse = left.inverse();
  return m;
}

// Returns the inverse inertia in world axes of a body with orientation q. Body is BodyState or RigidPiece.
template <class Body>
PALP_HD inline Mat3 world_inverse_inertia(const Body& b, const Quat& q) {
  const Mat3 R = q.toRotationMatrix();
  return R * b.inverse_inertia * R.transpose();
}

// Advances a body that nothing holds: by symplectic Euler for the centre; for the rotation the angular momentum is the
// state, so it is kept exactly, and the angular velocity is taken at mid-step, which keeps the energy to second order.
template <class Body>
PALP_HD inline void advance_free_body(Body& b, const Surroundings& around, real dt) {
  b.v = around.kept * (b.v + dt * (b.force / b.mass + around.pull));
  b.x += dt * b.v;
  b.L = around.kept * (b.L + dt * b.torque);
  const Quat middle = rotated(b.q, real(0.5) * dt * (world_inverse_inertia(b, b.q) * b.L));
  b.w = world_inverse_inertia(b, middle) * b.L;
  b.q = rotated(b.q, dt * b.w);
}

}  // namespace palp
