// Rigidification (paper 3.2): a piece all of whose particles are past a threshold of their material moves as one rigid
// body from that step on, until one of them is back.
//
// symbol   meaning                                                 unit      source
// x, v     centre of mass sum m x / M; its velocity sum m v / M    m, m/s
// I, L     sum m (r^2 - r r^T), sum m r x v, r from the centre     kg m^2, kg m^2/s
// w        I^-1 L                                                  rad/s
//
// So both momenta are kept and energy can only drop: motion that no rigid body can do is lost. Nothing else changes for
// the particles; forces on them are added up to force and torque, in which those within the piece cancel. A particle
// has no inertia of its own, so that momenta read from the particles are those of the body. Round an axis on which all
// particles lie there is no inertia and no torque, and the piece does not turn round it.
//
// Bonds go on within the piece and keep their strain and pressure, which balanced the forces from outside. So the piece
// is still in balance once it is deformable again, and strained parts spring back. Had its bonds taken their rest shape
// anew, the force on a rod held in it would have jumped by 60 % of the lift
// (tests/sim_server/physics/state_change_motion_test.cpp).
//
// A piece that holds a tool never becomes rigid: the tool's mass, which its coupling is made for, would change under
// the hand. Nor does one that reaches further than half of a periodic axis from its first particle, where it has no one
// place. There are kMaxRigidPieces at most, those of the least first particles; others stay deformable.
#pragma once

#include "sim_server/physics/pieces.h"
#include "sim_server/physics/principal_axes.h"

namespace palp {

inline constexpr std::uint32_t kMaxRigidPieces = 64;
inline constexpr std::uint32_t kRigidChunk = 256;  // slots that one thread counts first particles in

struct RigidPiece {
  Vec3 x, v, L, w;
  Quat q;
  Mat3 inverse_inertia;  // in the world axes of the moment at which it became rigid, which are its body axes
  real mass;
  Vec3 force, torque;
};

struct RigidViews {
  std::uint32_t* root = nullptr;  // by slot: first slot of its rigid piece, kNone; null where nothing becomes rigid
  Packed* local = nullptr;        // by slot: position from the centre in the piece's axes, mass [m, kg]
  Packed* push = nullptr;         // by slot: sum of all forces [N]
  RigidPiece* piece = nullptr;    // by root
  std::uint32_t* list = nullptr;  // [kMaxRigidPieces] roots, kNone
  // the results of the last change
  std::uint32_t* past = nullptr;   // by slot: 1 where it is past its threshold
  std::uint32_t* whole = nullptr;  // by root: 1 where all slots of the piece are
  std::uint32_t* same = nullptr;   // by root: 1 where it had the same particles before
  std::uint32_t* last = nullptr;   // by root: complement of its last slot
  std::uint32_t* place = nullptr;  // by root: index in the list, kNone
  std::uint32_t* roots = nullptr;  // by chunk: number of roots in it
};

inline std::uint32_t rigid_chunks(std::uint32_t slots) { return (slots + kRigidChunk - 1) / kRigidChunk; }

// Marks the slots that are past their threshold; one thread a particle.
struct MarkPastThreshold {
  ParticleView state;
  ChangeViews change;
  RigidViews rigid;
  ChangeMedium medium;

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = state.tag[i];
    const std::uint32_t k = slot_of(change, tag, state.id[i]);
    if (k == kNone) return;
    const std::uint32_t m = tag.material();
    const bool cold = state.temperature[i] < medium.rigid_below[m];
    const bool set = medium.rigid_when_set[m] && change.set[k] >= real(1);
    rigid.past[k] = tag.is_fluid() && (cold || set) ? 1 : 0;
    rigid.local[k].w = state.mass[i];
    rigid.whole[k] = rigid.same[k] = 1;
    rigid.last[k] = kNone;
  }
};

// Marks the pieces all of whose slots are; one thread a slot.
struct MarkWholePieces {
  ChangeViews change;
  RigidViews rigid;
  CellGrid grid;

  PALP_HD void operator()(std::uint32_t k) const {
    const std::uint32_t id = change.piece[k];
    if (id == kNone) return;
    if (rigid.past[k] == 0 || !has_one_place(k, id)) atomic_min(rigid.whole + id, 0);
  }

  // Returns true when a slot's partners have the same images as seen from the slot and from the piece's first one.
  PALP_HD bool has_one_place(std::uint32_t k, std::uint32_t id) const {
    if (!grid.periodic(0) && !grid.periodic(1) && !grid.periodic(2)) return true;
    const std::size_t row = std::size_t(k) * kMaxBonds;
    const Vec3 x_k = change.x[k].xyz(), r = separation(grid, x_k, change.x[id]);
    for (std::uint32_t b = 0; b < change.bonds[k]; ++b) {
      const std::uint32_t j = change.bond[row + b];
      if (change.piece[j] != id) continue;
      const Vec3 gap = r - separation(grid, change.x[j].xyz(), change.x[id]) - separation(grid, x_k, change.x[j]);
      for (int a = 0; a < 3; ++a)
        if (grid.periodic(a) && Eigen::numext::abs(gap[a]) > real(0.5) * grid.period[a]) return false;
    }
    return true;
  }
};

// Returns true when a slot is the first one of a piece that is to be rigid.
PALP_HD inline bool is_rigid_root(const ChangeViews& change, const RigidViews& rigid, std::uint32_t k) {
  return change.piece[k] == k && rigid.whole[k] != 0;
}

// Counts the roots of each chunk, and clears the list; one thread a chunk.
struct CountRoots {
  ChangeViews change;
  RigidViews rigid;
  std::uint32_t slots;

  PALP_HD void operator()(std::uint32_t c) const {
    if (c < kMaxRigidPieces) rigid.list[c] = kNone;
    std::uint32_t roots = 0;
    for (std::uint32_t k = c * kRigidChunk; k < (c + 1) * kRigidChunk && k < slots; ++k)
      if (is_rigid_root(change, rigid, k)) ++roots;
    if (c * kRigidChunk < slots) rigid.roots[c] = roots;
  }
};

// Lists the roots in the order of the slots; one thread a slot.
struct ListRoots {
  ChangeViews change;
  RigidViews rigid;

  PALP_HD void operator()(std::uint32_t k) const {
    rigid.place[k] = kNone;
    if (!is_rigid_root(change, rigid, k)) return;
    const std::uint32_t chunk = k / kRigidChunk;
    std::uint32_t place = 0;
    for (std::uint32_t c = 0; c < chunk; ++c) place += rigid.roots[c];
    for (std::uint32_t other = chunk * kRigidChunk; other < k; ++other)
      if (is_rigid_root(change, rigid, other)) ++place;
    if (place >= kMaxRigidPieces) return;
    rigid.place[k] = place;
    rigid.list[place] = k;
  }
};

// Assigns slots to rigid pieces, and marks the pieces that have changed; one thread a slot.
struct AssignRigid {
  ChangeViews change;
  RigidViews rigid;

  PALP_HD void operator()(std::uint32_t k) const {
    const std::uint32_t id = change.piece[k], before = rigid.root[k];
    const std::uint32_t now = id != kNone && rigid.place[id] != kNone ? id : kNone;
    if (now != before) {
      if (now != kNone) atomic_min(rigid.same + now, 0);
      if (before != kNone) atomic_min(rigid.same + before, 0);
      rigid.root[k] = now;
    }
    if (now != kNone) atomic_min(rigid.last + now, ~k);
  }
};

// Returns the inverse of an inertia on the axes round which there is some. Round others a piece does not turn: a row of
// particles, slightly bent, would spin there by many turns a sub-step. A needle of 2 x 2 particles is one from 245 on.
PALP_HD inline Mat3 turning_inverse(const Mat3& inertia) {
  const PrincipalAxes axes = principal_axes(inertia);
  const real most = axes.value.maxCoeff();
  Mat3 inverse = Mat3::Zero();
  for (int a = 0; a < 3; ++a)
    if (axes.value[a] > real(1e-4) * most) inverse += axes.axis.col(a) * axes.axis.col(a).transpose() / axes.value[a];
  return inverse;
}

// Computes the rigid motion of pieces that have become rigid or have changed; one team a piece of the list.
struct FormRigid {
  ChangeViews change;
  RigidViews rigid;
  CellGrid grid;

  template <class Team>
  PALP_HD void operator()(std::uint32_t p, Team team) const {
    const std::uint32_t root = rigid.list[p];
    if (root == kNone || rigid.same[root] != 0) return;
    const std::uint32_t end = ~rigid.last[root] + 1;
    const auto each = [&](auto&& f) {
      for (std::uint32_t k = root + team.lane(); k < end; k += team.size())
        if (rigid.root[k] == root) f(k, rigid.local[k].w);
    };
    const Packed x_root = change.x[root];
    real mass = 0;
    Vec3 moment(0, 0, 0), momentum(0, 0, 0);
    each([&](std::uint32_t k, real m) {
      mass += m;
      moment += m * separation(grid, change.x[k].xyz(), x_root);
      momentum += m * change.v[k].xyz();
    });
    mass = team.sum(mass);
    const Vec3 center = team.sum(moment) / mass, v = team.sum(momentum) / mass;
    Vec3 spin(0, 0, 0), diagonal(0, 0, 0), mixed(0, 0, 0);
    each([&](std::uint32_t k, real m) {
      const Vec3 r = separation(grid, change.x[k].xyz(), x_root) - center;
      spin += m * r.cross(change.v[k].xyz() - v);
      diagonal += m * r.cwiseProduct(r);
      mixed += m * Vec3(r.y() * r.z(), r.z() * r.x(), r.x() * r.y());
      rigid.local[k] = pack(r, m);
    });
    spin = team.sum(spin);
    diagonal = team.sum(diagonal);
    mixed = team.sum(mixed);
    if (!team.leader()) return;
    Mat3 inertia;
    inertia << diagonal.y() + diagonal.z(), -mixed.z(), -mixed.y(), -mixed.z(), diagonal.z() + diagonal.x(), -mixed.x(),
        -mixed.y(), -mixed.x(), diagonal.x() + diagonal.y();
    RigidPiece& piece = rigid.piece[root];
    piece.x = grid.wrap_fully(x_root.xyz() + center);
    piece.v = v;
    piece.L = spin;
    piece.q = Quat::Identity();
    piece.inverse_inertia = turning_inverse(inertia);
    piece.w = piece.inverse_inertia * spin;
    piece.mass = mass;
  }
};

// Adds up all forces on each particle of rigid pieces; one thread a particle.
struct GatherRigidForces {
  ParticleView state;
  const Packed* acceleration;
  ChangeViews change;
  RigidViews rigid;

  PALP_HD void operator()(std::uint32_t i) const {
    const std::uint32_t k = slot_of(change, state.tag[i], state.id[i]);
    if (k == kNone || rigid.root[k] == kNone) return;
    rigid.push[k] = pack(state.mass[i] * acceleration[i].xyz() + change.force[k].xyz(), 0);
  }
};

// Advances the rigid pieces; one team a piece of the list.
struct AdvanceRigid {
  RigidViews rigid;
  CellGrid grid;
  const Forcing* forcing;
  real dt;

  template <class Team>
  PALP_HD void operator()(std::uint32_t p, Team team) const {
    const std::uint32_t root = rigid.list[p];
    if (root == kNone) return;
    const std::uint32_t end = ~rigid.last[root] + 1;
    RigidPiece& piece = rigid.piece[root];
    const Mat3 R = piece.q.toRotationMatrix();
    Vec3 force(0, 0, 0), torque(0, 0, 0);
    for (std::uint32_t k = root + team.lane(); k < end; k += team.size()) {
      if (rigid.root[k] != root) continue;
      const Vec3 f = rigid.push[k].xyz();
      force += f;
      torque += (R * rigid.local[k].xyz()).cross(f);
    }
    force = team.sum(force);
    torque = team.sum(torque);
    if (!team.leader()) return;
    piece.force = force;
    piece.torque = torque;
    // the forces include its weight
    const Surroundings around = surroundings(grid, *forcing, piece.x, dt);
    advance_free_body(piece, {around.pull - forcing->gravity - forcing->body_force, around.kept}, dt);
    // the particles' velocities are to have the angular momentum where they are now
    piece.w = world_inverse_inertia(piece, piece.q) * piece.L;
  }
};

}  // namespace palp
