// The common part of contact of soft bodies with rigid and fixed ones: each particle, a ball half a spacing wide,
// touches the signed distance of the other body. Forces act in the particle's middle, so that both momenta are kept.
//
// A particle may begin nearer to a body than that: in the surface of a curved solid, where shapes overlap a little, or
// where it freezes. It may stay there until it has left, so that no start stores energy and freezing pushes nothing
// away.
#pragma once

#include "sim_server/physics/contact_law.h"

namespace palp {

// Returns the distance from a body at which contact of a particle begins, limit or what it was at when it was first
// seen in this state. distance: that to the body now.
PALP_HD inline real reach_of(ClosestApproach& kept, std::uint32_t solid, real limit, real distance) {
  if (kept.solid != solid || distance >= limit) {
    const real reach = distance < limit ? distance : limit;
    if (kept.solid != solid || kept.reach != reach) kept = {reach, solid};
  }
  return kept.reach;
}

// At what distance contact of a particle begins that has left the body once [m], and its ClosestApproach::solid.
struct SoftReach {
  real limit;
  std::uint32_t solid;
};

// A particle of a soft body. Apart from where it began, its displacement keeps the digits that places far from the
// origin are rounded to.
struct SoftParticle {
  Vec3 x, u, v;  // where it is, less u [m]; displacement [m]; velocity [m/s]
};

// Finds the touch of a particle, whose memory is contact state `place`, with the body of a pair, and keeps in state the
// side on which it came; a particle that is far away loses its memory of the contact. half: of a spacing [m].
PALP_HD inline PairPoints::Touch find_soft_touch(const PairPoints& all, const SoftParticle& particle,
                                                 const ContactPair& pair, const BodyState& field, const Mat3& R,
                                                 real half, const SoftReach& soft, std::uint32_t place,
                                                 ContactState& state) {
  const Motion motion{particle.x, particle.v, Vec3(0, 0, 0), false};
  PairPoints::Touch t =
      all.touch(motion, motion_of(field), particle.u, half, false, R, all.contact.shape[pair.shape_b], state.side);
  if (t.near)
    state.side = pack(R.transpose() * t.n, t.depth);
  else if (state.side.w > real(-1e29))
    state = no_contact();
  ClosestApproach& kept = all.contact.near[place - all.contact.first_soft];
  const real reach = reach_of(kept, soft.solid, soft.limit, t.near ? half - t.depth : half);
  if (t.near && reach < half) all.set_depth(t, t.depth - (half - reach));
  return t;
}

// Returns the inverse of a body's effective mass along n at the touch [1/kg], 0 for a fixed one.
PALP_HD inline real inverse_mass_along(const BodyState& field, const Mat3& R, const PairPoints::Touch& t) {
  if (field.kind != BodyKind::rigid) return real(0);
  const Vec3 b = R.transpose() * t.other.cross(t.n);
  return real(1) / field.mass + b.dot(field.inverse_inertia * b);
}

// Calls f(k, pair, field, R) for each pair k of a part. field: the other body; R: its axes.
template <class F>
PALP_HD inline void for_each_pair(const PairPoints& all, const SoftPart& part, F&& f) {
  for (std::uint32_t k = part.first_pair; k < part.first_pair + part.pairs; ++k) {
    const ContactPair& pair = all.contact.pair[k];
    const BodyState& field = all.body[pair.b];
    f(k, pair, field, field.q.toRotationMatrix());
  }
}

// Adds up the forces on the particles of a part by the body of pair k, and their torque on the body about its centre.
// force_on(i, place, torque): the force on particle i, whose memory is contact state `place` [N]; torque: of that force
// about the body's centre [N m].
template <class Team, class F>
PALP_HD inline void sum_soft_pair(const ContactViews& contact, const SoftPart& part, std::uint32_t k, Team team,
                                  F&& force_on) {
  Vec3 force(0, 0, 0), torque(0, 0, 0);
  for (std::uint32_t p = team.lane(); p < part.count; p += team.size()) {
    Vec3 about(0, 0, 0);
    const Vec3 f = force_on(part.first + p, contact.pair[k].first + p, about);
    if (f.isZero(0)) continue;
    force += f;
    torque -= about;
  }
  force = team.sum(force);
  torque = team.sum(torque);
  if (!team.leader()) return;
  PairWrench& out = contact.by.wrench[k];  // other teams may read the number of its contacts
  out.force = force;
  out.torque_b = torque;
}

}  // namespace palp
