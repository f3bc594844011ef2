// Keeps fluids out of solids by the solids' distance fields. A film or a drop that has spread has lost the density of
// those around it, so that it has no pressure before it is within a solid, and once it is, the solid's particles push
// from all sides: it went through tables of two layers.
//
// symbol   meaning                                                                                unit
// d, n     distance of a fluid particle from a solid; normal, outwards                            m, -
// v_n      its velocity against the solid along n                                                 m/s
// r0       kGuardReach dx; fluids that fill their space keep a larger distance                    m
// k        kGuardStiffness c^2 / (r0 dx): what comes with 0.12 c stops at the surface             1/s^2
// b        8 sqrt(k) (1 - d / r0): at the surface so much that what begins within a solid leaves  1/s
//          it slowly (4 sqrt(k) created energy there); none at r0, where a jump would make each touch a click
// a        (k (r0 - d) - (b + k dt) v_n) / (1 + b dt + k dt^2), no less than 0, where d < r0:     m/s^2
//          a spring and a damper by backward Euler
//
// It acts along the normal of the exact surface, and a liquid does not bounce. Springs from particle to particle, as
// stiff as the fluid, made such a wall rough: the force on a ladle that is stirred at a spacing of 20 mm erred by 42 %
// with them and errs by 16 %, with half of the noise. Bodies of loose particles and elastic ones have no distance
// field: guarding_pressure() of fluid.h serves there.
#pragma once

#include "sim_server/physics/distance.h"
#include "sim_server/physics/rigid.h"

namespace palp {

inline constexpr real kGuardReach = real(0.3);  // [spacings]
inline constexpr real kGuardStiffness = real(0.05);
inline constexpr std::uint32_t kGuardPart = 256;  // particles whose push on a body is summed at a time

struct FluidGuardViews {
  GuardWrenches by;
  const std::uint32_t* body = nullptr;  // the bodies that have a distance field
  const ContactBody* shape = nullptr;   // of each of them
  const Piece* piece = nullptr;
  const NodeGrid* grid = nullptr;
};

// Adds the guard to the accelerations of the particles of a part; one team a part. FluidForce has left there
// (acceleration.w) which share of the forces of a solid acts on a particle that is near one, else 0.
struct GuardFluid {
  ParticleView state;
  BodyViews bodies;
  FluidGuardViews guard;
  CellGrid grid;
  Medium medium;
  std::uint32_t count;
  Packed* acceleration;

  // Returns a n of a body for particle i. R: its axes; r: the particle's place from its centre, world axes [m].
  PALP_HD Vec3 push_on(std::uint32_t i, const BodyState& body, const ContactBody& shape, const Mat3& R,
                       const Vec3& r) const {
    const real reach = kGuardReach * medium.spacing;
    const Vec3 y = R.transpose() * r;
    if (outside_bounds(shape, y, reach)) return Vec3(0, 0, 0);
    const Distance at = solid_distance(shape, guard.piece, guard.grid, y);
    if (!(at.d < reach)) return Vec3(0, 0, 0);
    const Vec3 n = R * at.n;
    // a fixed wall's velocity is that of its surface along itself
    const Vec3 v_body = body.kind == BodyKind::fixed ? Vec3(0, 0, 0) : Vec3(body.v + body.w.cross(r));
    const real c = medium.material[state.tag[i].material()].sound_speed, dt = medium.dt;
    const real deep = reach - at.d, k = kGuardStiffness * c * c / (reach * medium.spacing);
    const real b = real(8) * Eigen::numext::sqrt(k) * deep / reach;
    const real a = k * deep - (b + k * dt) * (state.vp[i].xyz() - v_body).dot(n);
    return a > real(0) ? Vec3((a / (real(1) + b * dt + k * dt * dt)) * n) : Vec3(0, 0, 0);
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t part, Team team) const {
    const std::uint32_t begin = part * kGuardPart, end = begin + kGuardPart < count ? begin + kGuardPart : count;
    for (std::uint32_t k = 0; k < guard.by.bodies; ++k) {
      const BodyState& body = bodies.body[guard.body[k]];
      const bool asked = body.force_first != kNone;  // for its wrench
      const Mat3 R = body.q.toRotationMatrix();
      Vec3 force(0, 0, 0), torque(0, 0, 0);
      for (std::uint32_t i = begin + team.lane(); i < end; i += team.size()) {
        const Tag tag = state.tag[i];
        if (!tag.is_fluid() || tag.inactive() || (tag.asleep() && !asked)) continue;
        const real share = tag.asleep() ? real(1) : acceleration[i].w;  // what sleeps keeps no acceleration
        if (!(share > real(0))) continue;
        const Vec3 r = nearest_image(grid, state.xV[i].xyz() - body.x);
        const Vec3 push = share * push_on(i, body, guard.shape[k], R, r);
        if (push.isZero(0)) continue;
        force -= state.mass[i] * push;
        torque -= state.mass[i] * r.cross(push);
        if (!tag.asleep()) acceleration[i] = pack(acceleration[i].xyz() + push, share);
      }
      if (!asked) continue;
      force = team.sum(force);
      torque = team.sum(torque);
      if (team.leader()) guard.by.wrench[part * guard.by.bodies + k] = {force, torque};
    }
  }
};

}  // namespace palp
