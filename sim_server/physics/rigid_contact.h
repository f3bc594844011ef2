// Contact between two rigid or fixed bodies by the law of contact_law.h: how many points share a pair's load, and the
// wrenches that their forces add up to.
#pragma once

#include "sim_server/physics/contact_law.h"

namespace palp {

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
    for (std::uint32_t p = team.lane(); p < points + all.rounds(pair); p += team.size())
      all.contact.state[pair.first + p] = no_contact();
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
      if (by.part[p] / 2 >= by.rigid_pairs) break;
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
    const real mass = real(1) / (PairPoints::inverse_mass(a) + PairPoints::inverse_mass(b));
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
      const auto mass_along = [&](const Vec3& u) {
        return PairPoints::moving_mass(owner, field, R_owner, R_field, t, u);
      };
      const PairPoints::NormalForce normal = all.normal_force(pair.law, t, mass_along(t.n), load.sharing);
      const Vec3 f =
          all.force(pair.law, t, normal, t.mean / (load.sharing * load.depth), mass, mass_along, R_field, state);
      if (pair.law.implicit)
        add_resistance(resists, mine == held_a ? t.n : Vec3(-t.n), mine == held_a ? t.r : t.other, normal);
      const Vec3 on_a = mine ? f : Vec3(-f);
      force_a += on_a;
      torque_a += (mine ? t.r : t.other).cross(on_a);
      torque_b -= (mine ? t.other : t.r).cross(on_a);
    }
    force_a = team.sum(force_a);
    torque_a = team.sum(torque_a);
    torque_b = team.sum(torque_b);  // by now all have read the states of rounds
    for (std::uint32_t k = team.lane(); k < all.rounds(pair); k += team.size()) all.remember_round(pair, R_a, R_b, k);
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
