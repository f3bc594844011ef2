// Contact of elastic bodies with rigid and fixed ones: the kernels. What a touch is, and the spring that it is given:
// elastic_touching.h.
#pragma once

#include "sim_server/physics/elastic_touching.h"
#include "sim_server/physics/implicit_elastic.h"

namespace palp {

// Counts, by pair, the particles that touch a rigid body; one team a part.
struct CountElasticContacts {
  ElasticTouching touching;

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const ContactViews& contact = touching.all.contact;
    const SoftPart part = contact.elastic_part[index];
    if (touching.sleeps(part)) return;
    const auto count_in = [&](std::uint32_t k, const ContactPair& pair, const BodyState& field, const Mat3& R) {
      if (field.kind != BodyKind::rigid) return;
      real count = 0;
      for (std::uint32_t p = team.lane(); p < part.count; p += team.size()) {
        const std::uint32_t place = pair.first + p;
        ContactState state = contact.state[place];  // only the contact itself may go on with its memory
        const std::uint32_t i = part.first + p;
        const ElasticTouching::FaceTouch t = touching.find(part, p, pair, R, state);
        if (!t.near) continue;
        const Vec3 v = touching.velocity(i, t, touching.give_of(field, R, t));
        const bool loaded =
            contact.elastic_push != nullptr && touching.lasts(contact.elastic_push[place - contact.first_soft], field);
        if (loaded || t.depth > touching.all.dt * v.dot(t.n)) count += real(1);
      }
      count = team.sum(count);
      if (team.leader()) contact.by.wrench[k].contacts = count;
    };
    touching.for_each_near(part, team, count_in, [&](std::uint32_t k, const ContactPair&) {
      if (team.leader()) contact.by.wrench[k].contacts = real(0);
    });
  }
};

// Computes contact for explicit elasticity, and adds it to the particles' forces. One team a part, so that no two touch
// the same particle.
struct ElasticContact {
  ElasticTouching touching;

  PALP_HD Vec3 force_on(const SoftPart& part, std::uint32_t p, const ContactPair& pair, const BodyState& field,
                        const Mat3& R, real contacts, Vec3& torque) const {
    const PairPoints& all = touching.all;
    const std::uint32_t i = part.first + p;
    ContactState& state = all.contact.state[pair.first + p];
    const ElasticTouching::FaceTouch t = touching.find(part, p, pair, R, state);
    if (!t.near) return Vec3(0, 0, 0);
    const ElasticTouching::Candidate c = touching.candidate(i, t, field, R, contacts);
    if (!(c.push > real(0))) {
      state.anchor = {0, 0, 0, 0};
      return Vec3(0, 0, 0);
    }
    const real push = c.push / (real(1) + all.dt * c.q / c.mass);
    torque = (t.other + touching.press(i, push * t.n, c.at)).cross(push * t.n);
    if (!(pair.law.friction > real(0))) return push * t.n;
    Vec3 across = touching.sticking(c, R * state.anchor.xyz()) / (real(1) + all.dt * c.q_slip / c.mass);
    const real size = across.norm(), slips = state.anchor.w;
    const bool moves = size > (slips > real(0) ? pair.law.kinetic : pair.law.friction) * push;
    if (moves) across *= pair.law.kinetic * push / size;
    state.anchor = pack(R.transpose() * (across / -c.k_slip), moves ? real(1) : real(0));
    torque += t.other.cross(across);
    return push * t.n + across;
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const ContactViews& contact = touching.all.contact;
    const SoftPart part = contact.elastic_part[index];
    if (touching.sleeps(part)) return;
    touching.release(part, team);
    const auto push = [&](std::uint32_t k, const ContactPair& pair, const BodyState& field, const Mat3& R) {
      const real contacts = touching.contacts_of(pair.b, team);
      sum_soft_pair(contact, part, k, team, [&](std::uint32_t i, std::uint32_t place, Vec3& torque) {
        const Vec3 f = force_on(part, place - pair.first, pair, field, R, contacts, torque);
        touching.bodies.force[i] = pack(touching.bodies.force[i].xyz() + f, 0);
        return f;
      });
      if (team.leader()) contact.by.wrench[k].near = true;
    };
    touching.for_each_near(part, team, push,
                           [&](std::uint32_t k, const ContactPair& pair) { touching.forget(part, k, pair, team); });
  }
};

// Adds contact to the implicit solve's residual and matrix, once the elastic residual is known.
struct BeginElasticContact {
  ElasticTouching touching;
  ImplicitViews solve;

  // Returns the force across n for y = 0, and takes from c the resistance to slip where the particle slips.
  PALP_HD Vec3 friction(const ContactPair& pair, const Mat3& R, const ElasticPush& last, ElasticTouching::Candidate& c,
                        ContactState& state) const {
    const Vec3 s = R * state.anchor.xyz(), sticks = touching.sticking(c, s);
    const real dt = touching.all.dt, size = sticks.norm();
    const bool slid = state.anchor.w > real(0);
    // A particle's own mass is all that is known to press where it has just come, and to move it where it is held.
    const real load = last.touched ? last.load : c.push / (real(1) + dt * c.q / c.mass);
    const bool torn = size > pair.law.friction * load * (real(1) + dt * c.q_slip / c.mass);
    // A particle that slid is held once it turns back, but not where it swings: it would stop its body for a sub-step.
    const bool slips = last.touched ? slid && (torn || c.v.dot(s) > real(0)) : torn;
    const real holds = last.touched || last.owed > real(0) ? last.owed : pair.law.kinetic * load;
    if (!slips || !(size > real(0))) {
      state.anchor.w = real(0);
      return sticks;
    }
    state.anchor.w = real(1);
    c.q_slip = real(0);
    return (size > holds ? holds / size : real(1)) * sticks;
  }

  // Adds the contact of a part's particle p with the body of a pair.
  PALP_HD void add(const SoftPart& part, std::uint32_t p, const ContactPair& pair, const BodyState& field,
                   const Mat3& R, real contacts) const {
    const PairPoints& all = touching.all;
    const std::uint32_t i = part.first + p, place = pair.first + p;
    const real dt = all.dt;
    ContactState& state = all.contact.state[place];
    ElasticPush& out = all.contact.elastic_push[place - all.contact.first_soft];
    const ElasticTouching::FaceTouch t = touching.find(part, p, pair, R, state);
    if (!t.near) {
      out = no_elastic_push();
      return;
    }
    ElasticTouching::Candidate c = touching.candidate(i, t, field, R, contacts);
    const bool stays = c.push * dt > -kLongestGap * touching.medium.spacing * c.q;
    if (!(c.push > real(0)) && !(touching.lasts(out, field) && stays)) {
      const real owed = out.owed;
      out = no_elastic_push();
      out.owed = owed;
      state.anchor = {0, 0, 0, 0};
      return;
    }
    const Vec3 n = t.n;
    out.push = c.push * n;
    if (pair.law.friction > real(0))
      out.push += friction(pair, R, out, c, state);
    else
      c.q_slip = real(0);
    out.n = n;
    out.arm = t.other;
    out.at = c.at;
    out.resists = c.q;
    out.k_slip = c.k_slip;
    out.resists_slip = c.q_slip;
    solve.hold[i] += dt * ((c.q - c.q_slip) * n * n.transpose() + c.q_slip * Mat3::Identity());
    const Packed r = solve.residual[i];
    solve.residual[i] = pack(r.xyz() + dt * out.push, r.w);
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const ContactViews& contact = touching.all.contact;
    const SoftPart part = contact.elastic_part[index];
    if (touching.sleeps(part)) return;
    for (std::uint32_t p = team.lane(); p < part.count; p += team.size()) solve.hold[part.first + p] = Mat3::Zero();
    const auto begin = [&](std::uint32_t, const ContactPair& pair, const BodyState& field, const Mat3& R) {
      const real contacts = touching.contacts_of(pair.b, team);
      for (std::uint32_t p = team.lane(); p < part.count; p += team.size()) add(part, p, pair, field, R, contacts);
    };
    // EndElasticContact forgets the rest of a contact that ends so
    touching.for_each_near(part, team, begin, [&](std::uint32_t, const ContactPair& pair) {
      for (std::uint32_t p = team.lane(); p < part.count; p += team.size())
        contact.elastic_push[pair.first + p - contact.first_soft] = no_elastic_push();
    });
  }
};

// Finds the forces that contact has had once the solve is done, for the bodies' wrenches and for friction.
struct EndElasticContact {
  ElasticTouching touching;
  ImplicitViews solve;

  PALP_HD Vec3 force_on(std::uint32_t i, const ContactPair& pair, const Mat3& R, ElasticPush& push,
                        ContactState& state) const {
    const Vec3 y = solve.change[i].xyz(), along = y.dot(push.n) * push.n;
    const Vec3 f = push.push - push.resists * along - push.resists_slip * (y - along);
    const real load = f.dot(push.n);
    push.touched = true;
    push.load = load > real(0) ? load : real(0);
    push.at = touching.press(i, push.load * push.n, push.at);
    if (!(pair.law.friction > real(0))) return f;
    const Vec3 across = f - load * push.n;
    const real size = across.norm(), holds = pair.law.kinetic * push.load;
    const bool slid = state.anchor.w > real(0), slips = slid || size > pair.law.friction * push.load;
    const real owes = slid ? push.owed - size : real(0);
    push.owed = holds + (owes > real(0) ? owes : real(0));
    const real kept = slips && size > holds ? holds / size : real(1);
    state.anchor = pack(R.transpose() * (across * (kept / -push.k_slip)), slips ? real(1) : real(0));
    return f;
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const ContactViews& contact = touching.all.contact;
    const SoftPart part = contact.elastic_part[index];
    if (touching.sleeps(part)) return;
    touching.release(part, team);
    const auto end = [&](std::uint32_t k, const ContactPair& pair, const BodyState&, const Mat3& R) {
      sum_soft_pair(contact, part, k, team, [&](std::uint32_t i, std::uint32_t place, Vec3& torque) {
        ElasticPush& push = contact.elastic_push[place - contact.first_soft];
        if (push.n.isZero(0)) return Vec3(0, 0, 0);
        const Vec3 f = force_on(i, pair, R, push, contact.state[place]);
        torque = push.arm.cross(f) + push.at.cross(push.load * push.n);
        solve.outer[i] = pack(solve.outer[i].xyz() + touching.all.dt * f, 0);
        return f;
      });
      if (team.leader()) contact.by.wrench[k].near = true;
    };
    touching.for_each_near(part, team, end,
                           [&](std::uint32_t k, const ContactPair& pair) { touching.forget(part, k, pair, team); });
  }
};

}  // namespace palp
