// Elastic bodies by total-Lagrangian SPH: neighbours and kernel gradients are those of the rest state, so that lists
// never change and no tension makes particles clump.
//
// symbol      meaning                                                        source
// X_ji, x_ji  X_j - X_i at rest; now, x_ji = X_ji + u_j - u_i                displacements u keep small strains exact
// F           kernel: gradW(X_i - X_j) = F X_ji                              smoothing.h
// accurate:
//   of i      sums over j of the bonds that i's gradient is taken from         solver/elastic_stencil.h
//   L_i       (sum_j V_j F X_ji X_ji^T)^-1                                   Bonet & Lok 1999: affine fields exactly
//   F_i       sum_j V_j F x_ji (L_i X_ji)^T, deformation gradient
//   R_i       proper rotation nearest to F_i                                 rotation.h
//   P_i       2 mu (F_i - R_i) + lambda tr(R_i^T F_i - I) R_i                of mu |R^T F - I|^2 + lambda/2 tr^2
//   f_i       sum_j V_i V_j F (P_i L_i + P_j L_j) X_ji                       exact gradient of sum V psi(F): conserves
//                                                                            both momenta; P_i in bonds of F_i alone
//   h_i       -beta E sum_j V_i V_j F (d_i + d_j), d_i = F_i X_ji - x_ji     after Ganzenmueller 2015: against the
//                                                                            hourglass modes that F_i cannot see; exact
//                                                                            gradient of beta E / 2 sum V_i V_j F
//                                                                            |d_i|^2, since F_i makes that least; d_i
//                                                                            in bonds that are in F_i alone
//             in matter that yields d's part along x_ji alone acts, and no more of it than yields
// paper (Eq. 4 and 5, Becker, Ihmsen & Teschner 2009), without the factor that makes Eq. 4 twice too stiff for
// Cauchy's strain:
//   R_i       proper rotation nearest to sum_j m_j W x_ji X_ji^T
//   G_i       sum_j V_j F (R_i^T x_ji - X_ji) X_ji^T, gradient of the rotated-back displacement
//   f_i       sum_j V_i V_j F (R_i (I + G_i) s_i + R_j (I + G_j) s_j) X_ji, s = 2 mu e + lambda tr(e) I, e = sym(G)
// both:
//   damping   10 eta V_i V_j F (v_ji.x) x, x = x_ji / |x_ji|                 Monaghan 2005: central
#pragma once

#include "sim_server/physics/contact_stress.h"
#include "sim_server/physics/elastic_bond.h"
#include "sim_server/physics/plastic.h"
#include "sim_server/physics/rigid.h"

namespace palp {

// Particles of elastic bodies, and of rigid and fixed bodies bonded to them, in the order of BodyViews::force, of which
// they are the first. Bonded particles move with their body, but are strained as if they were of the elastic body's
// material: a clamp that felt nothing would be soft.
struct ElasticViews {
  std::uint32_t count = 0;
  const Packed* rest = nullptr;             // X, V [m, m^3]
  Tag* tag = nullptr;                       // with the elastic material; says who sleeps (elastic_sleep.h)
  const std::uint32_t* first = nullptr;     // [count + 1] index of each particle's first neighbour
  const std::uint32_t* neighbor = nullptr;  // index, marks (ElasticBond)
  Mat3* correction = nullptr;               // L; null with method "paper"
  Mat3* projection = nullptr;  // onto the plane or line that neighbours lie in, else I; null where all fill space
  Packed* u = nullptr;         // displacement [m]
  Packed* v = nullptr;         // velocity [m/s]
  Quat* rotation = nullptr;    // R
  Mat3* gradient = nullptr;    // F; R with method "paper"
  Mat3* stress = nullptr;      // factor of X_ji in the force: P L - beta E (F - I), or R (I + G) s with method "paper"
  Mat3* pressed = nullptr;     // pushes of contact on faces, as contact_stress takes them; null where nothing can touch
  real* stored = nullptr;      // elastic energy, for output alone (MeasureStored) [J]
  // where a material yields, else null
  Mat3* plastic = nullptr;   // inverse of the plastic part of F
  real* hardened = nullptr;  // accumulated plastic strain
  // where a material tears, else null (tear.h)
  std::uint8_t* torn = nullptr;  // like neighbor: 1 where the bond is broken
  Packed* stretch = nullptr;     // axis at rest and size of the greatest stretch, where that is near to tearing; else 0
  real* integrity = nullptr;     // share of the stress that a torn neighbourhood still bears

  PALP_HD ElasticBond bond(std::uint32_t k) const { return {neighbor[k]}; }
  PALP_HD bool bonded(std::uint32_t k) const { return torn == nullptr || torn[k] == 0; }

  // Returns true for a particle of a fixed body too deep in it for the bonds: it bears nothing and never moves.
  PALP_HD bool inert(std::uint32_t i) const { return tag[i].kind() == BodyKind::fixed && first[i] == first[i + 1]; }
};

// beta of the force against hourglass modes, and that where gradients are taken from balanced bonds. There this force
// stands for the moment of a strain that changes across a particle's own cell, too, which the strain at its middle has
// not: plates and bars bend and twist as in theory, down to four spacings across within 3 %.
inline constexpr real kHourglassShare = real(0.3), kBalancedHourglassShare = real(0.15);

// Returns the stress P [Pa].
PALP_HD inline Mat3 elastic_stress(const Material& m, const Mat3& F, const Mat3& R) {
  const real volume = (R.array() * F.array()).sum() - real(3);
  return real(2) * m.shear * (F - R) + m.lame * volume * R;
}

// Returns the elastic energy per volume at rest [J/m^3].
PALP_HD inline real elastic_energy(const Material& m, const Mat3& F, const Mat3& R) {
  const real volume = (R.array() * F.array()).sum() - real(3);
  return m.shear * (F - R).squaredNorm() + real(0.5) * m.lame * volume * volume;
}

// Returns the beta E that stands in ElasticViews::stress; yielding_hold() has that of matter that yields.
PALP_HD inline real hold_of(const Material& m) { return m.yield > real(0) ? real(0) : m.hourglass; }

// Returns f + h of a pair over V_i V_j F, for both solvers and for the bonds of state_change.h. It is S X + hold (x - A
// X) with S = P L - hold (F - A), each the sum over both sides, for any A. Displacements have A = I, so that no digits
// are lost near rest. x: x - A X.
PALP_HD inline Vec3 pair_force(const Mat3& S, const Vec3& X, real hold, const Vec3& x) {
  return mat_vec(S, X) + hold * x;
}

// Returns S of pair_force() of one side, where change is F - A. In one expression Eigen would keep the address of
// `change`, and a GPU's compiler the whole of what that is part of in memory.
PALP_HD inline Mat3 pair_factor(const Mat3& P, const Mat3& L, real hold, const Mat3& change) {
  Mat3 S = P * L;
  S -= hold * change;
  return S;
}

// Returns beta E d_i.x_ji of matter that yields, which must not keep it from flowing [Pa m^2].
PALP_HD inline real yielding_hold(const Material& m, const Mat3& F, const Vec3& X_ji, const Vec3& x_ji) {
  const real r2 = x_ji.squaredNorm(), most = kHourglassShare * m.yield * r2;
  const real held = m.hourglass * (mat_vec(F, X_ji).dot(x_ji) - r2);
  return held > most ? most : (held < -most ? -most : held);
}

PALP_HD inline Vec3 rest_separation(const CellGrid& grid, const Packed& X_i, const Packed& X_j) {
  return separation(grid, X_j.xyz(), X_i);
}

template <class Team>
PALP_HD inline Mat3 team_sum(Team team, const Mat3& m) {
  Mat3 out;
  for (int c = 0; c < 3; ++c) out.col(c) = team.sum(Vec3(m.col(c)));
  return out;
}

// The deformation of a particle.
struct DeformationGradient {
  Mat3 F, change;  // change: F - I
  Quat q;          // rotation nearest to F; of matter that yields and fills space the guess
};

// Returns the deformation that displacements make, displaced = sum V F u_ji X_ji^T. within:
// ElasticViews::projection; guess: of the rotation.
PALP_HD inline DeformationGradient deformation_of(const Mat3& displaced, const Mat3& L, const Mat3& within, bool yields,
                                                  const Quat& guess) {
  const Mat3 change = displaced * L;
  DeformationGradient d{within + change, change, guess};
  const bool flat = within.trace() < real(2.5);
  if (flat || !yields) d.q = closest_rotation(d.F, guess);
  if (!flat) return d;
  // where neighbours span no space, across them nothing is strained
  const Mat3 across = Mat3::Identity() - within, R = d.q.toRotationMatrix();
  d.F += R * across;
  d.change += (R - Mat3::Identity()) * across;
  return d;
}

// Computes rotation, deformation gradient and stress of each elastic particle. kYields: some material yields.
template <bool kYields>
struct ElasticStrain {
  ElasticViews elastic;
  BodyViews bodies;
  CellGrid grid;
  WendlandC2 kernel;
  Medium medium;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag = elastic.tag[i];
    const Packed X_i = elastic.rest[i];
    const Vec3 u_i = elastic.u[i].xyz();
    Mat3 displaced = Mat3::Zero();  // sum V F u_ji X_ji^T
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      const ElasticBond bond = elastic.bond(k);
      if (!bond.in_mine() || !elastic.bonded(k)) continue;
      const std::uint32_t j = bond.j();
      const Packed X_j = elastic.rest[j];
      const Vec3 X_ji = rest_separation(grid, X_i, X_j);
      const real weight = X_j.w * kernel.F(X_ji.norm());
      displaced += (weight * (elastic.u[j].xyz() - u_i)) * X_ji.transpose();
    }
    displaced = team_sum(team, displaced);
    if (!team.leader()) return;
    const Mat3 L = elastic.correction[i];
    const Mat3 within = elastic.projection != nullptr ? elastic.projection[i] : Mat3(Mat3::Identity());
    const Material& m = medium.material[tag.material()];
    const bool yields = kYields && m.yield > real(0);
    DeformationGradient d = deformation_of(displaced, L, within, yields, elastic.rotation[i]);
    Mat3 P = Mat3::Zero();
    if (kYields && yields)
      P = plastic_stress(m, d.F, d.q, elastic.plastic[i], elastic.hardened[i]);
    else
      P = elastic_stress(m, d.F, d.q.toRotationMatrix());
    if (elastic.integrity != nullptr) P *= elastic.integrity[i];
    if (elastic.pressed != nullptr && !elastic.pressed[i].isZero(0)) {
      P += contact_stress(elastic.pressed[i], d.F);
      P += contact_damping(elastic.gradient[i], d.F, m.shear, m.density, medium.spacing, medium.dt);
    }
    elastic.rotation[i] = d.q;
    elastic.gradient[i] = d.F;
    elastic.stress[i] = pair_factor(P, L, hold_of(m), d.change);
    if (elastic.stretch != nullptr && m.tear > real(0))
      elastic.stretch[i] = greatest_stretch(d.F, real(1) + real(0.5) * m.tear);
  }
};

// Computes rotation and stress by the paper's equations.
struct PaperStrain {
  ElasticViews elastic;
  BodyViews bodies;
  CellGrid grid;
  WendlandC2 kernel;
  Medium medium;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag = elastic.tag[i];
    const Packed X_i = elastic.rest[i];
    const Vec3 u_i = elastic.u[i].xyz();
    Mat3 A = Mat3::Zero(), at_rest = Mat3::Zero(), now = Mat3::Zero();
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      const std::uint32_t j = elastic.bond(k).j();
      const Packed X_j = elastic.rest[j];
      const Vec3 X_ji = rest_separation(grid, X_i, X_j), x_ji = X_ji + elastic.u[j].xyz() - u_i;
      const real r = X_ji.norm(), weight = X_j.w * kernel.F(r);
      A += (X_j.w * kernel.W(r) * x_ji) * X_ji.transpose();
      at_rest += (weight * X_ji) * X_ji.transpose();
      now += (weight * x_ji) * X_ji.transpose();
    }
    A = team_sum(team, A);
    at_rest = team_sum(team, at_rest);
    now = team_sum(team, now);
    if (!team.leader()) return;
    const Quat q = closest_rotation(A, elastic.rotation[i]);
    const Mat3 R = q.toRotationMatrix();
    const Mat3 G = R.transpose() * now - at_rest;
    const Mat3 strain = real(0.5) * (G + G.transpose());
    const Material& m = medium.material[tag.material()];
    const Mat3 s = real(2) * m.shear * strain + m.lame * strain.trace() * Mat3::Identity();
    elastic.rotation[i] = q;
    elastic.gradient[i] = R;
    elastic.stress[i] = R * (Mat3::Identity() + G) * s;
  }
};

// Computes the force on each particle, bonded ones included, and writes it to BodyViews::force, or adds it (add).
struct ElasticForce {
  ElasticViews elastic;
  BodyViews bodies;
  CellGrid grid;
  WendlandC2 kernel;
  Medium medium;
  bool hourglass, add;

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Material m = medium.material[elastic.tag[i].material()];
    const Packed X_i = elastic.rest[i];
    const Vec3 u_i = elastic.u[i].xyz(), v_i = elastic.v[i].xyz();
    const Mat3 stress_i = elastic.stress[i];
    Vec3 force(0, 0, 0);
    for (std::uint32_t k = elastic.first[i] + team.lane(); k < elastic.first[i + 1]; k += team.size()) {
      if (!elastic.bonded(k)) continue;
      const ElasticBond bond = elastic.bond(k);
      const std::uint32_t j = bond.j();
      const Packed X_j = elastic.rest[j];
      const Material& m_j = medium.material[elastic.tag[j].material()];
      const Vec3 X_ji = rest_separation(grid, X_i, X_j), u_ji = elastic.u[j].xyz() - u_i, x_ji = X_ji + u_ji;
      const real VVF = X_i.w * X_j.w * kernel.F(X_ji.norm());
      const real hold = hourglass ? bond.sum(hold_of(m), hold_of(m_j)) : real(0);
      const real damping = real(5) * (m.damping + m_j.damping);
      force += VVF * pair_force(bond.sum(stress_i, elastic.stress[j]), X_ji, hold, u_ji);
      real pull = 0;  // along x_ji, times |x_ji|
      if (hourglass && m.yield > real(0) && bond.in_mine()) pull -= yielding_hold(m, elastic.gradient[i], X_ji, x_ji);
      if (hourglass && m_j.yield > real(0) && bond.in_theirs())
        pull -= yielding_hold(m_j, elastic.gradient[j], X_ji, x_ji);
      if (damping > real(0)) pull += damping * (elastic.v[j].xyz() - v_i).dot(x_ji);
      const real r2 = x_ji.squaredNorm();
      if (r2 > real(0)) force += (VVF * pull / r2) * x_ji;
    }
    force = team.sum(force);
    if (!team.leader()) return;
    if (add) force += bodies.force[i].xyz();
    bodies.force[i] = pack(force, 0);
  }
};

// Moves the particles by symplectic Euler; bonded ones follow their body.
struct MoveElastic {
  ElasticViews elastic;
  BodyViews bodies;
  Medium medium;
  CellGrid grid;
  const Forcing* forcing;

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = elastic.tag[i];
    const Packed X = elastic.rest[i];
    if (tag.kind() != BodyKind::elastic) {
      const BodyState& body = bodies.body[tag.body()];
      const Vec3 r = body.q * bodies.local[i].xyz();
      // a fixed body stays where it is: computed anew its place would be rounded, and strain what holds on to it; so
      // would the place of another far from the origin, were it summed before X is taken off
      if (tag.kind() != BodyKind::fixed) elastic.u[i] = pack((body.x - X.xyz()) + r, 0);
      elastic.v[i] = pack(body.v + body.w.cross(r), 0);
      return;
    }
    const real mass = medium.material[tag.material()].density * X.w;
    const Surroundings around = surroundings(grid, *forcing, X.xyz() + elastic.u[i].xyz(), medium.dt);
    const Vec3 v = around.kept * (elastic.v[i].xyz() + medium.dt * (bodies.force[i].xyz() / mass + around.pull));
    const Vec3 u = elastic.u[i].xyz() + medium.dt * v;
    elastic.v[i] = pack(v, 0);
    elastic.u[i] = pack(u, 0);
    // for the torque on the body as a whole
    const BodyState& body = bodies.body[tag.body()];
    bodies.local[i] = pack(body.q.conjugate() * (X.xyz() + u - body.x), 0);
  }
};

// Measures the elastic energy of each particle, that against hourglass modes included, at the deformation that its last
// forces were of; for output alone. Method "paper", whose forces are the gradient of no energy, has none.
struct MeasureStored {
  ElasticViews elastic;
  CellGrid grid;
  WendlandC2 kernel;
  Medium medium;

  // Returns the displacement that a particle had when forces last acted.
  PALP_HD Vec3 before(std::uint32_t i) const { return elastic.u[i].xyz() - medium.dt * elastic.v[i].xyz(); }

  // Returns sum V_j F |d_ij|^2.
  PALP_HD real hourglass(std::uint32_t i, const Mat3& F) const {
    real sum = 0;
    for (std::uint32_t k = elastic.first[i]; k < elastic.first[i + 1]; ++k) {
      const ElasticBond bond = elastic.bond(k);
      if (!bond.in_mine() || !elastic.bonded(k)) continue;
      const std::uint32_t j = bond.j();
      const Packed X_j = elastic.rest[j];
      const Vec3 X_ji = rest_separation(grid, elastic.rest[i], X_j);
      const Vec3 d = mat_vec(F, X_ji) - X_ji - (before(j) - before(i));
      sum += X_j.w * kernel.F(X_ji.norm()) * d.squaredNorm();
    }
    return sum;
  }

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = elastic.tag[i];
    elastic.stored[i] = 0;
    if (elastic.correction == nullptr || tag.kind() != BodyKind::elastic) return;
    const Material& m = medium.material[tag.material()];
    const Mat3 F = elastic.gradient[i], R = elastic.rotation[i].toRotationMatrix();
    real density = 0;
    if (m.yield > real(0))
      density = plastic_energy(m, F * elastic.plastic[i], R);
    else
      density = elastic_energy(m, F, R);
    if (elastic.integrity != nullptr) density *= elastic.integrity[i];
    if (hold_of(m) > real(0)) density += real(0.5) * hold_of(m) * hourglass(i, F);
    if (elastic.pressed != nullptr) density += contact_energy(elastic.pressed[i], F, R);
    elastic.stored[i] = elastic.rest[i].w * density;
  }
};

// Measures centre, momentum and mean rotation of each elastic body, for output alone; one team a body.
struct MeasureElastic {
  ElasticViews elastic;
  BodyViews bodies;
  const std::uint32_t* body;  // indices of the elastic bodies

  template <class Team>
  PALP_HD void operator()(std::uint32_t k, Team team) const {
    BodyState& b = bodies.body[body[k]];
    if (elastic.tag[b.force_first].asleep()) {  // it stays where it was
      if (team.leader()) b.v = b.L = b.w = Vec3(0, 0, 0);
      return;
    }
    Vec3 u(0, 0, 0), v(0, 0, 0), center(0, 0, 0);
    real volume = 0;
    for (std::uint32_t i = b.force_first + team.lane(); i < b.force_first + b.count; i += team.size()) {
      const Packed X = elastic.rest[i];
      u += X.w * elastic.u[i].xyz();
      v += X.w * elastic.v[i].xyz();
      center += X.w * X.xyz();
      volume += X.w;
    }
    volume = team.sum(volume);
    u = team.sum(u) / volume;
    v = team.sum(v) / volume;
    center = team.sum(center) / volume;
    Mat3 A = Mat3::Zero(), spread = Mat3::Zero();
    Vec3 L(0, 0, 0);
    for (std::uint32_t i = b.force_first + team.lane(); i < b.force_first + b.count; i += team.size()) {
      const Packed X = elastic.rest[i];
      const Vec3 R = X.xyz() - center, r = R + elastic.u[i].xyz() - u;
      A += (X.w * r) * R.transpose();
      spread += (X.w * r) * r.transpose();
      L += X.w * r.cross(elastic.v[i].xyz() - v);
    }
    A = team_sum(team, A);
    spread = team_sum(team, spread);
    L = team.sum(L);
    if (!team.leader()) return;
    const real density = b.mass / volume;
    b.x = center + u;
    b.v = v;
    b.q = closest_rotation(A, b.q);
    b.L = density * L;
    const Mat3 inertia = density * (spread.trace() * Mat3::Identity() - spread);
    b.w = inertia.determinant() > real(0) ? Vec3(inertia.inverse() * b.L) : Vec3(0, 0, 0);
  }
};

}  // namespace palp
