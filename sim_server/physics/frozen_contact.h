// Contact of matter that has frozen or set (state_change.h) with rigid and fixed bodies, by the law of contact_law.h:
// it gets the solid's share K of the force, while the fluid's forces keep 1 - K (bonded.h).
//
// m_i = min(m of the particle, m_b / n): m_b is the other body's effective mass along the normal at the particle, n the
// number of contacts that may act on it at once (BodyState::contact_mass), so that all of them together are stable on
// either side.
//
// A drop that tore off has lost the density of those that it left, and no pressure keeps it out of a wall before it is
// deep inside: liquid particles meet walls too, without friction, at a fifth of a spacing, where fluids otherwise do
// not get to.
#pragma once

#include "sim_server/physics/soft_contact.h"
#include "sim_server/physics/state_change.h"

namespace palp {

// Computes contact of the matter that changes state, by slot. One team a part, so that no two touch the same particle.
struct FrozenContact {
  PairPoints all;
  ChangeViews change;
  Medium medium;

  PALP_HD bool rough(std::uint32_t i) const { return change.solid[i] > real(0); }

  PALP_HD SoftReach reach(std::uint32_t i, real half) const {
    return rough(i) ? SoftReach{half, 1} : SoftReach{real(0.4) * half, 0};
  }

  // Returns m_i.
  PALP_HD real moving_mass(std::uint32_t i, const BodyState& field, const Mat3& R, const PairPoints::Touch& t) const {
    const real particle = medium.material[change.tag[i].material()].density * change.x[i].w;
    if (field.kind != BodyKind::rigid) return particle;
    const real other = field.contact_mass / (field.mass * inverse_mass_along(field, R, t));
    return other < particle ? other : particle;
  }

  PALP_HD Vec3 force_on(std::uint32_t i, const ContactPair& pair, const BodyState& field, const Mat3& R,
                        std::uint32_t place, Vec3& arm) const {
    if (!(change.x[i].w > real(0))) return Vec3(0, 0, 0);
    ContactState& state = all.contact.state[place];
    const real half = real(0.5) * medium.spacing;
    const SoftParticle particle{change.x[i].xyz(), Vec3(0, 0, 0), change.v[i].xyz()};
    const PairPoints::Touch t = find_soft_touch(all, particle, pair, field, R, half, reach(i, half), place, state);
    if (!t.near) return Vec3(0, 0, 0);
    if (!(t.mean > real(0))) {
      state.anchor = {0, 0, 0, 0};
      return Vec3(0, 0, 0);
    }
    arm = t.other;
    ContactLaw law = pair.law;
    if (!rough(i)) law.friction = real(0);
    const real m = (rough(i) ? change.solid[i] : real(1)) * moving_mass(i, field, R, t);
    return all.force(
        law, t, all.normal_force(law, t, m, real(1)), real(1), m, [m](const Vec3&) { return m; }, R, state);
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const SoftPart part = all.contact.frozen_part[index];
    for_each_pair(all, part, [&](std::uint32_t k, const ContactPair& pair, const BodyState& field, const Mat3& R) {
      sum_soft_pair(all.contact, part, k, team, [&](std::uint32_t i, std::uint32_t place, Vec3& torque) {
        Vec3 arm(0, 0, 0);
        const Vec3 f = force_on(i, pair, field, R, place, arm);
        torque = arm.cross(f);
        change.force[i] = pack(change.force[i].xyz() + f, 0);
        return f;
      });
    });
  }
};

}  // namespace palp
