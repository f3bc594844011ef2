// Contact of elastic bodies with rigid and fixed ones: each particle, a ball half a spacing wide, against their signed
// distances, by the law of contact.h. Forces act in the particle's middle, so that both momenta are kept.
//
// m_i = min(m of the particle, m_b / n): m_b is what of the other body moves along n at the particle, n the number of
// contacts that may act on it at once (BodyState::contact_mass), so that all of them together are stable on either
// side.
#pragma once

#include "sim_server/physics/contact.h"
#include "sim_server/physics/elastic.h"

namespace palp {

// One team a part of an elastic body: no two teams touch the same particle.
struct MeetElastic {
  PairPoints all;
  ElasticViews elastic;
  BodyViews bodies;
  Medium medium;

  PALP_HD static real moving_mass(real particle, const BodyState& field, const Mat3& R, const PairPoints::Touch& t) {
    if (field.kind != Kind::rigid) return particle;
    const Vec3 b = R.transpose() * t.other.cross(t.n);
    const real share = field.contact_mass / field.mass;
    const real other = share / (real(1) / field.mass + b.dot(field.inverse_inertia * b));
    return other < particle ? other : particle;
  }

  // Of particle i by the pair's b; none without contact.
  PALP_HD Vec3 force_on(std::uint32_t i, const ContactPair& pair, const BodyState& field, const Mat3& R,
                        ContactState& state, Vec3& arm) const {
    const Packed X = elastic.rest[i];
    const Motion particle{X.xyz() + elastic.u[i].xyz(), elastic.v[i].xyz(), Vec3(0, 0, 0), false};
    const PairPoints::Touch t = all.touch(particle, motion_of(field), Vec3(0, 0, 0), real(0.5) * medium.spacing, false,
                                          R, all.contact.shape[pair.shape_b], state.side);
    if (!t.near) {
      if (state.side.w > real(-1e29)) state = no_contact();
      return Vec3(0, 0, 0);
    }
    state.side = pack(R.transpose() * t.n, t.depth);
    if (!(t.mean > real(0))) {
      state.anchor = {0, 0, 0, 0};
      return Vec3(0, 0, 0);
    }
    arm = t.other;
    const real m = moving_mass(medium.material[elastic.tag[i].material()].density * X.w, field, R, t);
    return all.force(pair.law, t, m, real(1), real(1), R, state);
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const ElasticPart part = all.contact.elastic_part[index];
    for (std::uint32_t k = part.first_pair; k < part.first_pair + part.pairs; ++k) {
      const ContactPair pair = all.contact.pair[k];
      const BodyState& field = all.body[pair.b];
      const Mat3 R = field.q.toRotationMatrix();
      Vec3 force(0, 0, 0), torque(0, 0, 0);
      for (std::uint32_t p = team.lane(); p < part.count; p += team.size()) {
        const std::uint32_t i = part.first + p;
        Vec3 arm(0, 0, 0);
        const Vec3 f = force_on(i, pair, field, R, all.contact.state[pair.first + p], arm);
        if (f.isZero(0)) continue;
        bodies.force[i] = pack(bodies.force[i].xyz() + f, 0);
        force += f;
        torque -= arm.cross(f);
      }
      force = team.sum(force);
      torque = team.sum(torque);
      if (!team.leader()) continue;
      PairWrench out = no_wrench();
      out.force = force;
      out.torque_b = torque;
      all.contact.by.wrench[k] = out;
    }
  }
};

}  // namespace palp
