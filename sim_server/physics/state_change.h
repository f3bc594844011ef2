// Matter that changes state: melts, freezes, sets for good when cooked (paper 3.2). Its particles stay fluid particles
// throughout. Those that are partly solid have bonds to one another, which carry the solid's share of the forces.
//
// symbol      meaning                                                        source
// K_i         solid fraction K^d; K^f = 1 - K^d                              paper 3.2
// X_ij        x_j - x_i when the bond formed, in i's frame                   one for each direction of a bond
// F_i         sum_j K_j V_j F(X) x_ji (L_i X_ij)^T, L_i its correction       elastic.h
// R_i, P_i    rotation nearest to F_i; stress                                elastic.h
// f_i         sum_j K_i K_j V_i V_j (F(X_ij) P_i L_i X_ij - F(X_ji) P_j L_j X_ji) - V_i V_j F q_ij x_ji
// h_i         -beta E sum_j K_i K_j V_i V_j (F(X_ij) d_ij - F(X_ji) d_ji), d_ij = F_i X_ij - x_ji        elastic.h
// b_i         sum_j K_i K_j V_i V_j F(R) 30 eta (R/H)^2 (v_ji.n) n, n = x_ji / |x_ji|, R = (|X_ij| + |X_ji|) / 2
// q_ij        pressure that the fluid's p_i + p_j lost with its share while the bond got stiffer
// share       1 - K_i K_j, of a pair's fluid forces                          bonded.h
//
// f and h are exact gradients, of sum K_i V_i psi(F_i) and of beta E / 2 sum K_i K_j V_i V_j F(X_ij) |d_ij|^2, so that
// pairs conserve momentum, and angular momentum with them. A bond forms without strain. When it gets stiffer, the added
// stiffness is unstrained too: its X moves towards x by the share of the new stiffness in the whole. The pressure that
// the fluid forces lose with their share stays in the bond, as q, until it melts. So nothing jumps. A pair of bonded
// solids keeps no fluid force; their pressure then is that of the fluid that touches them.
//
// b is the damping of elastic.h times 3 (R/H)^2, which is the same where space is filled evenly. A fluid freezes with
// two particles at a tenth of a spacing from each other here and there. elastic.h's damping is eight times that of
// neighbours on a lattice there, which was too much for the sub-step: they threw each other off.
#pragma once

#include "sim_server/physics/bonded.h"
#include "sim_server/physics/elastic.h"
#include "sim_server/physics/gradient_correction.h"
#include "sim_server/physics/heat.h"

namespace palp {

// The most bonds of a particle. On a lattice with a support of two spacings it has 26, in a dense fluid somewhat more.
inline constexpr std::uint32_t kMaxBonds = 64;

// Arrays by slot. Slots are the particles of bodies that change state, and of bodies that these are bonded to.
struct ChangeViews {
  std::uint32_t count = 0;
  const std::uint32_t* slot_of = nullptr;  // by body: its slots less the particles' ids; kNoDifference: it has none
  const std::uint32_t* group = nullptr;    // by body: bonds form within a group
  const std::uint32_t* shaped = nullptr;   // by body: Bonded::shaped
  const Tag* tag = nullptr;                // with the material of its bonds
  Packed* x = nullptr;                     // position, rest volume; 0: it has left the domain [m, m^3]
  Packed* v = nullptr;                     // velocity, acting pressure of a fluid particle [m/s, Pa]
  real* solid = nullptr;                   // K
  real* before = nullptr;                  // K before its last change
  real* set = nullptr;                     // share of the matter that has set for good
  Quat* rotation = nullptr;                // R
  Mat3* stress = nullptr;                  // factor of X_ij in the force: soft (P L - beta E F)
  Mat3* correction = nullptr;              // L
  Mat3* projection = nullptr;              // onto the directions that neighbours span; I where they fill space
  real* soft = nullptr;                    // factor of its stress, 0..1
  std::uint32_t* piece = nullptr;          // least slot of its piece (pieces.h); kNone: liquid
  std::uint32_t* acting = nullptr;         // the piece that fluid forces use: that of one change earlier
  Packed* force = nullptr;                 // [N]
  std::uint32_t* bonds = nullptr;          // number of its bonds
  std::uint32_t* bond = nullptr;           // [kMaxBonds] slots of its partners
  Packed* own = nullptr;                   // [kMaxBonds] X_ij, q [m, Pa]
  Packed* other = nullptr;                 // [kMaxBonds] X_ji
};

// Returns the slot of a particle, kNone where it has none.
PALP_HD inline std::uint32_t slot_of(const ChangeViews& change, Tag tag, std::uint32_t id) {
  const std::uint32_t first = change.slot_of[tag.body()];
  return first == kNoDifference ? kNone : first + id;
}

// The constants of changes of state.
struct ChangeMedium {
  HeatMaterial heat[kMaxMaterials];
  real cooking[kMaxMaterials];       // temperature from which it sets [K]; 0: never
  real cooking_rate[kMaxMaterials];  // growth of the share that has set [1/s]
  real rigid_below[kMaxMaterials];   // temperature below which solid matter is rigid [K]; 0: never
  bool rigid_when_set[kMaxMaterials];
  real dt;         // time between two changes [s]
  real support;    // H of bonds [m]
  real slack;      // largest distance of a particle from the place that the grid has for it [m]
  real max_reach;  // sum |dF/dx| up to which a particle has its full stiffness [1/m]
};

// Computes solid fractions from enthalpy and temperature; one thread a particle.
struct ChangeFractions {
  ParticleView state;
  ChangeViews change;
  ChangeMedium medium;

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = state.tag[i];
    const std::uint32_t k = slot_of(change, tag, state.id[i]);
    if (k == kNone) return;
    const real K = change.solid[k];
    change.before[k] = K;
    if (!tag.is_fluid() || tag.inactive()) return;
    const std::uint32_t m = tag.material();
    real now = change.set[k];
    if (medium.cooking[m] > real(0) && state.temperature[i] > medium.cooking[m]) {
      now += medium.dt * medium.cooking_rate[m];
      if (now > real(1)) now = real(1);
      change.set[k] = now;
    }
    if (medium.heat[m].latent > real(0)) {
      const real frozen = real(1) - liquid_fraction(medium.heat[m], state.enthalpy[i]);
      if (frozen > now) now = frozen;
    }
    change.solid[k] = now;
    state.solid[i].K = now;
    if (!(K > real(0))) change.rotation[k] = Quat::Identity();
  }
};

// The share of the largest principal value of the moment sum K_j V_j F X X^T below which a particle has no bonds along
// an axis: faces, edges and corners of a lattice have 0.5 and more.
inline constexpr real kFlatBonds = real(0.3);

// Returns the factor of a particle's stress. Where a frozen fluid's neighbours lie unevenly a gradient weighs single
// ones so much that the particle would be stiffer than any on a lattice, and the sub-step too long for it. reach: sum_j
// |dF/dx_j| over it and its neighbours.
PALP_HD inline real bond_softness(real reach, real max_reach) {
  const real ratio = max_reach / reach;
  return reach > max_reach ? ratio * ratio : real(1);
}

// Ends, stiffens and forms bonds; one thread a particle. Each writes its own side of its bonds, from data that both
// sides read.
struct ChangeBonds {
  ParticleView state;
  ChangeViews change;
  CellGrid grid;
  WendlandC2 kernel;
  ChangeMedium medium;

  // One particle of a bond.
  struct Side {
    std::uint32_t slot;
    Tag tag;
    Packed x;
    real p;
    Mat3 R_T;
    real K, before;
    std::uint32_t piece, acting;
  };
  PALP_HD Side side(std::uint32_t k) const {
    return {k,
            change.tag[k],
            change.x[k],
            change.v[k].w,
            change.rotation[k].toRotationMatrix().transpose(),
            change.solid[k],
            change.before[k],
            change.piece[k],
            change.acting[k]};
  }
  // Returns the growth of the share of the fluid forces that a bonded pair has lost.
  PALP_HD real withdrawn(const Side& i, std::uint32_t j) const {
    const real now = may_be_bonded(i.piece, change.piece[j]) ? i.K * change.solid[j] : real(0);
    const real before = may_be_bonded(i.acting, change.acting[j]) ? i.before * change.before[j] : real(0);
    return now - before;
  }
  // Returns p_i + p_j; a tool shows the pressure of the matter that it is bonded to.
  PALP_HD real pressures(const Side& i, std::uint32_t j) const {
    const real p_j = change.v[j].w;
    return (i.tag.is_fluid() ? i.p : p_j) + (change.tag[j].is_fluid() ? p_j : i.p);
  }

  // Updates the bond at place `from` of i's and writes it to place n; returns false when it ends.
  PALP_HD bool update_bond(const Side& i, std::uint32_t from, std::uint32_t n) const {
    const std::size_t row = std::size_t(i.slot) * kMaxBonds;
    const std::uint32_t j = change.bond[row + from];
    const real k1 = i.K * change.solid[j], k0 = i.before * change.before[j];
    if (!(k1 > real(0))) return false;
    const Packed kept = change.own[row + from];
    Vec3 own = kept.xyz(), other = change.other[row + from].xyz();
    real q = kept.w;
    const Vec3 x_ji = separation(grid, change.x[j].xyz(), i.x);
    // mush that was stirred apart: the bond ends
    if (k1 < real(1) && x_ji.norm() > own.norm() + other.norm()) return false;
    if (k1 > k0) {
      const real old = k0 / k1;
      own = old * own + (real(1) - old) * (i.R_T * x_ji);
      other = old * other - (real(1) - old) * (change.rotation[j].conjugate().toRotationMatrix() * x_ji);
    }
    const real more = withdrawn(i, j);
    if (more > real(0))
      q += more * pressures(i, j);
    else if (k1 < k0)
      q *= k1 / k0;
    if (!(own.norm() < medium.support) && !(other.norm() < medium.support)) return false;
    change.bond[row + n] = j;
    change.own[row + n] = pack(own, q);
    change.other[row + n] = pack(other, 0);
    return true;
  }

  // Forms a bond to j where there is none and the pair gets stiffer, or where two pieces have become one; returns the
  // number of bonds.
  PALP_HD std::uint32_t form_bond(const Side& i, std::uint32_t j, const Vec3& x_ji, std::uint32_t n) const {
    const std::size_t row = std::size_t(i.slot) * kMaxBonds;
    const bool stiffer = i.K * change.solid[j] > i.before * change.before[j];
    const real more = withdrawn(i, j);
    if (n == kMaxBonds || !(stiffer || more > real(0))) return n;
    for (std::uint32_t b = 0; b < n; ++b)
      if (change.bond[row + b] == j) return n;
    change.bond[row + n] = j;
    change.own[row + n] = pack(i.R_T * x_ji, more > real(0) ? more * pressures(i, j) : real(0));
    change.other[row + n] = pack(-(change.rotation[j].conjugate().toRotationMatrix() * x_ji), 0);
    return n + 1;
  }

  // Computes the correction of the gradient from the bonds.
  PALP_HD void correct(const Side& i, std::uint32_t bonds) const {
    const std::size_t row = std::size_t(i.slot) * kMaxBonds;
    Mat3 moment = Mat3::Zero();
    for (std::uint32_t b = 0; b < bonds; ++b) {
      const std::uint32_t j = change.bond[row + b];
      const Vec3 X = change.own[row + b].xyz();
      moment += (change.solid[j] * change.x[j].w * kernel.F(X.norm()) * X) * X.transpose();
    }
    const GradientCorrection<real> c = gradient_correction(moment, kFlatBonds);
    Vec3 all(0, 0, 0);
    real reach = 0;
    for (std::uint32_t b = 0; b < bonds; ++b) {
      const Vec3 X = change.own[row + b].xyz();
      const real weight = change.solid[change.bond[row + b]] * change.x[change.bond[row + b]].w * kernel.F(X.norm());
      const Vec3 slope = weight * mat_vec(c.inverse, X);
      all += slope;
      reach += slope.norm();
    }
    change.correction[i.slot] = c.inverse;
    change.projection[i.slot] = c.projection;
    change.soft[i.slot] = bond_softness(reach + all.norm(), medium.max_reach);
  }

  PALP_HD void operator()(std::uint32_t p) const {
    const Tag tag = state.tag[p];
    const std::uint32_t k = slot_of(change, tag, state.id[p]);
    if (k == kNone) return;
    const Side i = side(k);
    std::uint32_t n = 0;
    if (i.K > real(0)) {
      for (std::uint32_t b = 0; b < change.bonds[k]; ++b)
        if (update_bond(i, b, n)) ++n;
      const std::uint32_t group = change.group[tag.body()];
      const Vec3 x_i = state.xV[p].xyz();
      const real reach = medium.support;
      for_each_run(grid, x_i, reach + medium.slack, SerialTeam{},
                   [&](std::uint32_t begin, std::uint32_t end, const Vec3&) {
                     for (std::uint32_t q = begin; q < end; ++q) {
                       const Tag tag_q = state.tag[q];
                       if (q == p || change.group[tag_q.body()] != group) continue;
                       // two tools in one lump of matter are bonded to it, not to each other
                       if (!tag.is_fluid() && !tag_q.is_fluid() && tag.body() != tag_q.body()) continue;
                       const std::uint32_t j = slot_of(change, tag_q, state.id[q]);
                       if (j == kNone) continue;
                       const Vec3 x_ji = separation(grid, change.x[j].xyz(), i.x);
                       if (x_ji.squaredNorm() < reach * reach) n = form_bond(i, j, x_ji, n);
                     }
                   });
    }
    change.bonds[k] = n;
    correct(i, n);
  }
};

// Computes rotation, deformation gradient and stress; one team a slot.
struct BondStrain {
  ChangeViews change;
  CellGrid grid;
  WendlandC2 kernel;
  Medium medium;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const std::uint32_t bonds = change.bonds[i];
    if (bonds == 0) return;
    const std::size_t row = std::size_t(i) * kMaxBonds;
    const Packed x_i = change.x[i];
    Mat3 F = Mat3::Zero();
    for (std::uint32_t b = team.lane(); b < bonds; b += team.size()) {
      const std::uint32_t j = change.bond[row + b];
      const Vec3 X = change.own[row + b].xyz(), x_ji = separation(grid, change.x[j].xyz(), x_i);
      F += (change.solid[j] * change.x[j].w * kernel.F(X.norm()) * x_ji) * X.transpose();
    }
    F = team_sum(team, F);
    if (!team.leader()) return;
    const Mat3 L = change.correction[i];
    F = F * L;
    const Quat q = closest_rotation(F, change.rotation[i]);
    const Mat3 R = q.toRotationMatrix();
    // where neighbours span no space, across them nothing is strained
    F += R * (Mat3::Identity() - change.projection[i]);
    change.rotation[i] = q;
    const Material& m = medium.material[change.tag[i].material()];
    change.stress[i] = change.soft[i] * pair_factor(elastic_stress(m, F, R), L, m.hourglass, F);
  }
};

// Computes the force of the bonds; one team a slot. That on particles of bodies is added to the forces on their body.
struct BondForce {
  ChangeViews change;
  BodyViews bodies;
  const std::uint32_t* force_of;  // by body: index of its slots in bodies.force less the slot; kNoDifference: none
  CellGrid grid;
  WendlandC2 kernel;
  Medium medium;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag = change.tag[i];
    const Material m = medium.material[tag.material()];
    const real hold_i = change.soft[i] * m.hourglass;
    const std::size_t row = std::size_t(i) * kMaxBonds;
    const Packed x_i = change.x[i];
    const Vec3 v_i = change.v[i].xyz();
    const Mat3 stress_i = change.stress[i];
    Vec3 force(0, 0, 0);
    for (std::uint32_t b = team.lane(); b < change.bonds[i]; b += team.size()) {
      const std::uint32_t j = change.bond[row + b];
      const Packed own_q = change.own[row + b];
      const Vec3 own = own_q.xyz(), other = change.other[row + b].xyz();
      const Vec3 x_ji = separation(grid, change.x[j].xyz(), x_i);
      const real r_own = own.norm(), r_other = other.norm(), r = real(0.5) * (r_own + r_other);
      const real VV = x_i.w * change.x[j].w, KVV = change.solid[i] * change.solid[j] * VV;
      const Material& m_j = medium.material[change.tag[j].material()];
      const real hold_j = change.soft[j] * m_j.hourglass;
      force += KVV * (kernel.F(r_own) * pair_force(stress_i, own, hold_i, x_ji) -
                      kernel.F(r_other) * pair_force(change.stress[j], other, hold_j, -x_ji));
      force -= VV * kernel.F(r) * own_q.w * x_ji;
      const real near = r * kernel.inv_support, damping = real(15) * near * near * (m.damping + m_j.damping);
      const real r2 = x_ji.squaredNorm();
      if (r2 > real(0)) force += (KVV * kernel.F(r) * damping * (change.v[j].xyz() - v_i).dot(x_ji) / r2) * x_ji;
    }
    force = team.sum(force);
    if (!team.leader()) return;
    change.force[i] = pack(force, 0);
    if (tag.is_fluid() || force_of[tag.body()] == kNoDifference) return;
    Packed& on_body = bodies.force[force_of[tag.body()] + i];
    on_body = pack(on_body.xyz() + force, 0);
  }
};

}  // namespace palp
