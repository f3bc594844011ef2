// Contact of soft bodies with rigid and fixed ones: each particle, a ball half a spacing wide, against their signed
// distances, by the law of rigid_contact.h. Forces act in the particle's middle, so that both momenta are kept.
//
// m_i = min(m of the particle, m_b / n): m_b is the other body's effective mass along the normal at the particle, n the
// number of contacts that may act on it at once (BodyState::contact_mass), so that all of them together are stable on
// either side.
#pragma once

#include "sim_server/physics/elastic.h"
#include "sim_server/physics/rigid_contact.h"

namespace palp {

// The matter of elastic bodies, by their particles in the order of forces.
struct ElasticMatter {
  ElasticViews elastic;
  BodyViews bodies;
  Medium medium;

  // Returns true for a particle that takes part in contact.
  PALP_HD bool acts(std::uint32_t) const { return true; }
  // Returns the share of the contact's forces that a particle gets.
  PALP_HD real share(std::uint32_t) const { return real(1); }
  // Returns true for a particle that friction acts on.
  PALP_HD bool rough(std::uint32_t) const { return true; }
  PALP_HD Motion motion(std::uint32_t i) const {
    return {elastic.rest[i].xyz() + elastic.u[i].xyz(), elastic.v[i].xyz(), Vec3(0, 0, 0), false};
  }
  PALP_HD real mass(std::uint32_t i) const {
    return medium.material[elastic.tag[i].material()].density * elastic.rest[i].w;
  }
  PALP_HD void add(std::uint32_t i, const Vec3& f) const { bodies.force[i] = pack(bodies.force[i].xyz() + f, 0); }
  // Returns the distance at which contact begins; only frozen matter remembers a smaller one.
  PALP_HD real reach(std::uint32_t, std::uint32_t, real half, real) const { return half; }
};

// Computes contact of soft matter with rigid and fixed bodies. One team a part of a soft body, so that no two teams
// touch the same particle.
template <class Matter>
struct SoftContact {
  PairPoints all;
  const SoftPart* parts;
  Matter matter;
  real spacing;

  PALP_HD static real moving_mass(real particle, const BodyState& field, const Mat3& R, const PairPoints::Touch& t) {
    if (field.kind != BodyKind::rigid) return particle;
    const Vec3 b = R.transpose() * t.other.cross(t.n);
    const real share = field.contact_mass / field.mass;
    const real other = share / (real(1) / field.mass + b.dot(field.inverse_inertia * b));
    return other < particle ? other : particle;
  }

  // Returns the force on particle i by the pair's body b, zero without contact.
  PALP_HD Vec3 force_on(std::uint32_t i, const ContactPair& pair, const BodyState& field, const Mat3& R,
                        std::uint32_t place, Vec3& arm) const {
    ContactState& state = all.contact.state[place];
    const real half = real(0.5) * spacing;
    PairPoints::Touch t = all.touch(matter.motion(i), motion_of(field), Vec3(0, 0, 0), half, false, R,
                                    all.contact.shape[pair.shape_b], state.side);
    const real reach = matter.reach(i, place, half, t.near ? half - t.depth : half);
    if (!t.near) {
      if (state.side.w > real(-1e29)) state = no_contact();
      return Vec3(0, 0, 0);
    }
    state.side = pack(R.transpose() * t.n, t.depth);
    if (reach < half) all.set_depth(t, t.depth - (half - reach));
    if (!(t.mean > real(0))) {
      state.anchor = {0, 0, 0, 0};
      return Vec3(0, 0, 0);
    }
    arm = t.other;
    ContactLaw law = pair.law;
    if (!matter.rough(i)) law.friction = real(0);
    const real m = matter.share(i) * moving_mass(matter.mass(i), field, R, t);
    return all.force(law, t, m, all.normal_force(law, t, m, real(1)), real(1), R, state);
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const SoftPart part = parts[index];
    for (std::uint32_t k = part.first_pair; k < part.first_pair + part.pairs; ++k) {
      const ContactPair pair = all.contact.pair[k];
      const BodyState& field = all.body[pair.b];
      const Mat3 R = field.q.toRotationMatrix();
      Vec3 force(0, 0, 0), torque(0, 0, 0);
      for (std::uint32_t p = team.lane(); p < part.count; p += team.size()) {
        const std::uint32_t i = part.first + p;
        if (!matter.acts(i)) continue;
        Vec3 arm(0, 0, 0);
        const Vec3 f = force_on(i, pair, field, R, pair.first + p, arm);
        if (f.isZero(0)) continue;
        matter.add(i, f);
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
