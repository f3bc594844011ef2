// Moves the particles at the end of a sub-step: fluids by symplectic Euler, rigid bodies' particles with
// their body, elastic ones to where elastic.h moved them. Matter that changes state moves as a fluid with bonds, or as
// part of a rigid piece.
#pragma once

#include "sim_server/physics/outside.h"
#include "sim_server/physics/rigid_pieces.h"
#include "sim_server/physics/shift.h"

namespace palp {

struct MoveParticles {
  ParticleView state;
  const Packed* acceleration;  // fluids only
  const Packed* shift_sums;    // as of shift_of(); null where no fluid is shifted
  BodyViews bodies;
  ElasticViews elastic;
  ChangeViews change;
  RigidViews rigid;
  CellGrid grid;
  Medium medium;
  const Forcing* forcing;

  // Deactivates a liquid particle at x with velocity v when it has left the domain; returns true if it did. A particle
  // faster than sound has not left, but diverged: it goes on, so that health sees it.
  PALP_HD bool deactivate(std::uint32_t i, std::uint32_t slot, const Vec3& x, const Vec3& v) const {
    const Vec3 pull = forcing->gravity + forcing->body_force;
    const real c = medium.material[state.tag[i].material()].sound_speed;
    if (!has_left(grid, x, pull) || !(v.squaredNorm() < c * c)) return false;
    const Packed kept = pack(inactive_position(grid, x, pull), state.xV[i].w), still = pack(Vec3(0, 0, 0), 0);
    state.xV[i] = kept;
    state.vp[i] = still;
    state.tag[i] = state.tag[i].as_inactive();
    if (slot == kNone) return true;
    change.x[slot] = pack(kept.xyz(), 0);
    change.v[slot] = still;
    return true;
  }

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = state.tag[i];
    if (tag.kind() == BodyKind::fixed || tag.inactive()) return;
    const Packed xV = state.xV[i], vp = state.vp[i];
    const std::uint32_t slot = change.count > 0 ? slot_of(change, tag, state.id[i]) : kNone;
    Vec3 x, v;
    const std::uint32_t root = slot != kNone && rigid.root != nullptr ? rigid.root[slot] : kNone;
    if (root != kNone) {
      const RigidPiece& piece = rigid.piece[root];
      const Vec3 r = piece.q * rigid.local[slot].xyz();
      v = piece.v + piece.w.cross(r);
      x = grid.wrap_fully(piece.x + r);
    } else if (tag.is_fluid()) {
      v = vp.xyz() + medium.dt * acceleration[i].xyz();
      if (slot != kNone) v += medium.dt / state.mass[i] * change.force[slot].xyz();
      if (slot != kNone && change.solid[slot] > real(0)) {
        const Surroundings around = surroundings(grid, *forcing, xV.xyz(), medium.dt);
        if (around.kept < real(1)) v = around.kept * (v - medium.dt * (forcing->gravity + forcing->body_force));
      } else if (deactivate(i, slot, xV.xyz(), v)) {
        return;
      }
      x = xV.xyz() + medium.dt * v;
      if (shift_sums != nullptr) x += shift_of(medium, tag, state.id[i], shift_sums[i], state.smooth[i]);
    } else {
      const BodyState& body = bodies.body[tag.body()];
      const std::uint32_t k = body.force_first + state.id[i] - body.first;
      if (tag.kind() == BodyKind::elastic) {
        v = elastic.v[k].xyz();
        x = grid.wrap_fully(elastic.rest[k].xyz() + elastic.u[k].xyz());
      } else {
        const Vec3 r = body.q * bodies.local[k].xyz();
        v = body.v + body.w.cross(r);
        x = grid.wrap_fully(body.x + r);
      }
    }
    x = grid.wrap(x);
    state.xV[i] = pack(x, xV.w);
    state.vp[i] = pack(v, vp.w);
    if (slot == kNone) return;
    change.x[slot] = pack(x, change.x[slot].w);
    change.v[slot] = pack(v, tag.is_fluid() ? acting_pressure(medium, vp.w) : real(0));
  }
};

}  // namespace palp
