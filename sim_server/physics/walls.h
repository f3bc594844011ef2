// Solids as fluids feel them, from their geometry alone: no particles stand in them. What a solid adds to the sums over
// a fluid particle's neighbours are the integrals of wall_share.h, with the pressure and velocity that the fluid has
// there, continued into the solid.
//
// symbol      meaning                                                                                   unit
// V, p, rho   of the fluid particle                                                                     m^3, Pa, kg/m^3
// d, n, r     its distance from the solid; normal, outwards; place from the body's centre               m, -, m
// v_b         velocity of the body, at r if nothing else is said                                        m/s
// p_w         p + rho g_f . s at s from the particle; g_f: near_body.h                                  Pa
// rate        m slope . (v - v_b), what the divergence of the velocity gets; m = kMirror: below          1/s
// f^p         V (2 p slope - rho pull(g_f)): the sum of -(p + p_w) gradW over the solid                  N
// f^v         -2 mu V shear (v - v_b(r - d n)): of a flow that grows in proportion to the distance,     N
//             within a layer that is thinner than that at most (near_body.h)
// couple      sum of (r - d n) x (2 mu V slope x w) on the body: below                                  N m
//
// A film or a drop that has spread has lost the density of those around it, so that it has no pressure before it is
// within a solid; what keeps it out is a guard:
// r0          kGuardReach dx, where fluid that fills its space is at rest farther off                   m
// k           kGuardStiffness c^2 / (r0 dx): what comes with 0.09 c stops at the surface                1/s^2
// b           8 sqrt(k) (1 - d / r0): at the surface so much that what begins within a solid leaves     1/s
//             it slowly (4 sqrt(k) created energy there); none at r0, where a jump would make each
//             touch a click
// q           mass of the particle over the share of the body's mass that each of its contacts moves    -
// a           (k (r0 - d) - (b + k dt) v_n) / (1 + (1 + q) (b dt + k dt^2)), no less than 0, where      m/s^2
//             d < r0: a spring and a damper by backward Euler
//
// What flows around a body comes as near to it as its streamlines do, and a guard that stops it there is felt as a
// collision: with twice the reach a ladle of 1.25 spacings in radius is felt by a tenth more.
//
// The wall mirrors the fluid: its pressure is the particle's own, so that one which is the same everywhere pushes
// nowhere. The rate to match has m = 2, as if the wall's velocity along the normal were the opposite of the particle's;
// with less, work of the pressure is not known to the density and feeds sound. But for a flow that follows the wall m =
// 1 is right, and more reads walls that come nearer as compression. kMirror lies between, and density diffuses beside
// walls at rest, too (fluid.h), which damps what is fed: with 1 a tray at rest began to boil (H = 2 dx) all the same,
// with 1.25 and 1.5 it comes to rest, to 0.1 uJ in four seconds, where it had 24 with solids of particles.
//
// The body receives the opposite of f^p at the particle's own place and of f^v at r - d n, on its surface. So momentum
// is kept to rounding, and angular momentum as well as viscosity between particles keeps it, which is not central.
//
// What f^v, and the viscosity between particles, leave out is mu (grad v)^T n of the traction. Within the fluid its
// divergence vanishes, so the flow is right without it, but on a body that turns with w it is mu n x w, of which a
// closed surface makes no force, but the couple -2 mu w V: a third of the torque on a ball. The body receives that (2 V
// slope of the particles beside a surface adds up to n dA), and the fluid nothing: it hands it on to where the flow
// ends.
//
// Bodies of loose particles and elastic ones have no distance field: boundary.h and guarding_pressure() of
// fluid.h serve there.
#pragma once

#include "sim_server/physics/near_body.h"

namespace palp {

inline constexpr real kMirror = real(1.25);
inline constexpr real kMostYielding = real(3);  // (w dt)^2 of a body on the pressure of one particle; 21 was not stable
// The most that (w dt)^2 + 2 a dt may be of a particle beside solids: w, a: of its swinging on their pressure and of
// its drag, which gives way, to 2 a dt = kLeastDrag where the swinging takes all. With more than 4 it swings to and fro
// and ever farther, and the fluid beside it takes up to 1.6 of that. Half a spacing off one face comes to 1.6 at most
// by the planned sub-step, so what is limited lies nearer, or where faces meet.
inline constexpr real kMostSwing = real(1.8), kLeastDrag = real(0.3);
inline constexpr real kGuardReach = real(0.15);  // [spacings]
inline constexpr real kGuardStiffness = real(0.05);

// Returns what passes solids as particle i.
PALP_HD inline Passing passing_of(const ParticleView& state, const Medium& medium, const Forcing& forcing,
                                  std::uint32_t i) {
  const Material& fluid = medium.material[state.tag[i].material()];
  return {state.vp[i].xyz(), forcing.level_gravity, fluid.viscosity / fluid.density};
}

// Finds the cells of a domain without periods that are out of the reach of all fixed bodies; one thread a cell.
// Outermost cells have particles from outside, too, and so are never open.
struct MarkOpenCells {
  const BodyState* bodies;
  WallViews walls;
  CellGrid grid;
  Medium medium;

  PALP_HD void operator()(std::uint32_t c) const {
    int at[3];
    grid.cell_at(c, at);
    bool open = true;
    Vec3 x;
    for (int a = 0; a < 3; ++a) {
      open = open && at[a] > 0 && at[a] + 1 < grid.n[a];
      x[a] = grid.origin[a] + (static_cast<real>(at[a]) + real(0.5)) * grid.cell[a];
    }
    const real reach = medium.kernel.support + real(0.5) * grid.cell.norm() + (walls.nodes ? medium.spacing : real(0));
    for (std::uint32_t k = 0; open && k < walls.by.bodies; ++k) {
      const BodyState& body = bodies[walls.body[k]];
      if (body.kind != BodyKind::fixed) continue;
      const Vec3 y = body.q.toRotationMatrix().transpose() * (x - body.x);
      open = outside_bounds(walls.shape[k], y, reach) ||
             !(solid_distance(walls.shape[k], walls.piece, walls.grid, y).d < reach);
    }
    walls.open[c] = open ? 1 : 0;
  }
};

// Measures what solids add to the sums of the density's rate of a part's particles, and keeps what they are to them;
// one team a part.
template <class Bonds>
struct MeasureWalls {
  ParticleView state;
  BodyViews bodies;
  WallViews walls;
  CellGrid grid;
  Medium medium;  // without viscosity where that is taken in stages
  const Forcing* forcing;
  std::uint32_t count;
  Bonds bonds;

  // Returns the share of the rate that a body resists: all, but for a body that is lighter than what the pressure of
  // particle i moves it by in a sub-step allows for. It yields before it is squeezed.
  PALP_HD real resisting(std::uint32_t i, const NearBody& b, const BodyState& body) const {
    if (body.kind != BodyKind::rigid) return real(1);
    const Material& fluid = medium.material[state.tag[i].material()];
    const real stiffness =
        real(2) * kMirror * state.xV[i].w * b.wall.slope.squaredNorm() * bulk_modulus(fluid.density, fluid.sound_speed);
    const real most = kMostYielding * body.mass / (stiffness * medium.dt * medium.dt);
    return most < real(1) ? most : real(1);
  }

  PALP_HD bool open_at(const Vec3& x) const { return walls.open != nullptr && walls.open[grid.index_of(x)] != 0; }

  PALP_HD void keep(std::uint32_t i, const Vec3& slope, real share, real rate, std::uint32_t beside) const {
    walls.slope[i] = pack(slope, share);
    walls.rate[i] = rate;
    walls.beside[i] = beside;
  }

  // Says whether a solid may be beside a particle; of a fluid's that has none it keeps that there is nothing, unless
  // that is what is kept already.
  PALP_HD bool may_be_beside(std::uint32_t i) const {
    const Tag tag = state.tag[i];
    if (!tag.is_fluid() || tag.inactive()) return false;
    const Vec3 x = state.xV[i].xyz();
    const bool open = open_at(x);
    bool may = false;
    for (std::uint32_t k = 0; !may && k < walls.by.bodies; ++k) {
      const BodyState& body = bodies.body[walls.body[k]];
      may = !(open && body.kind == BodyKind::fixed) && !far_from_body(walls, grid, medium, body, k, x);
    }
    if (!may && walls.beside[i] != 0) keep(i, Vec3(0, 0, 0), 0, 0, 0);
    return may;
  }

  PALP_HD void measure(std::uint32_t i) const {
    const Tag tag = state.tag[i];
    Vec3 slope(0, 0, 0);
    real share = 0, rate = 0, shear = 0;
    std::uint32_t beside = 0;
    const Vec3 x = state.xV[i].xyz();
    const Passing passing = passing_of(state, medium, *forcing, i);
    const bool open = open_at(x);
    for (std::uint32_t k = 0; k < walls.by.bodies; ++k) {
      const BodyState& body = bodies.body[walls.body[k]];
      if (open && body.kind == BodyKind::fixed) continue;
      const NearBody b = near_body(walls, grid, medium, body, k, x, &passing);
      if (!b.near) continue;
      if (beside < kKeptBodies) walls.kept[i * kKeptBodies + beside] = kept_body(b, k);
      ++beside;
      slope += b.wall.slope;
      share += b.wall.share;
      shear += b.wall.shear;
      rate += kMirror * resisting(i, b, body) * bonds.wall_share(tag, bonds.solid(state, i), walls.body[k]) *
              b.wall.slope.dot(state.vp[i].xyz() - b.v);
    }
    keep(i, slope, share, rate, beside);
    const real left = share_of_drag(i, slope, shear);
    for (std::uint32_t s = 0; left < real(1) && s < kKeptBodies && s < beside; ++s)
      walls.kept[i * kKeptBodies + s].n_shear.w *= left;
  }

  // Returns the share of the drag of solids that a sub-step leaves stable; slope and shear: of all of them.
  PALP_HD real share_of_drag(std::uint32_t i, const Vec3& slope, real shear) const {
    const Material& fluid = medium.material[state.tag[i].material()];
    const real c_dt = fluid.sound_speed * medium.dt;
    const real drag = real(4) * fluid.viscosity * state.xV[i].w * shear * medium.dt / state.mass[i];  // 2 a dt
    const real left = kMostSwing - real(2) * kMirror * c_dt * c_dt * slope.squaredNorm();
    const real most = left > kLeastDrag ? left : kLeastDrag;
    return drag > most ? most / drag : real(1);
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t part, Team team) const {
    const WallRange range = wall_range(walls, part, count);
    std::uint32_t near = 0;
    team.for_those(
        range.begin, range.end, [&](std::uint32_t i) { return may_be_beside(i); },
        [&](std::uint32_t i) {
          ++near;
          measure(i);
        });
    near = team.sum(near);
    if (team.leader()) walls.near[part] = near;
  }
};

// Adds the forces of solids to the accelerations of the particles of a part; one team a part.
template <class Bonds>
struct WallForce {
  ParticleView state;
  BodyViews bodies;
  WallViews walls;
  CellGrid grid;
  Medium medium;
  const Forcing* forcing;
  std::uint32_t count;
  Packed* acceleration;
  Bonds bonds;

  // Returns the acceleration of particle i by the guard of a body.
  PALP_HD Vec3 guard_push(std::uint32_t i, const NearBody& b, const BodyState& body) const {
    const real reach = kGuardReach * medium.spacing, dt = medium.dt;
    if (!(b.d < reach)) return Vec3(0, 0, 0);
    const real c = medium.material[state.tag[i].material()].sound_speed;
    const real deep = reach - b.d, k = kGuardStiffness * c * c / (reach * medium.spacing);
    const real damper = real(8) * Eigen::numext::sqrt(k) * deep / reach;
    const real a = k * deep - (damper + k * dt) * (state.vp[i].xyz() - b.v).dot(b.n);
    const real both = real(1) + state.mass[i] / body.contact_mass;
    return a > real(0) ? Vec3((a / (real(1) + (damper * dt + k * dt * dt) * both)) * b.n) : Vec3(0, 0, 0);
  }

  // Returns what a particle beside a body that turns with w adds to the couple on it [N m].
  PALP_HD Vec3 couple(std::uint32_t i, const NearBody& b, const Vec3& w) const {
    const real mu = medium.material[state.tag[i].material()].viscosity;
    return b.foot.cross(real(2) * mu * state.xV[i].w * b.wall.slope.cross(w));
  }

  // Returns the drag of a solid on a particle.
  PALP_HD Vec3 drag_on(std::uint32_t i, const NearBody& b) const {
    const real mu = medium.material[state.tag[i].material()].viscosity;
    return (real(-2) * mu * state.xV[i].w * b.wall.shear) * (state.vp[i].xyz() - b.v_foot);
  }

  // Returns the pressure of a solid on a particle, as a force.
  PALP_HD Vec3 pressure_on(std::uint32_t i, const NearBody& b) const {
    const Material& fluid = medium.material[state.tag[i].material()];
    const Packed xV = state.xV[i], vp = state.vp[i];
    const real rho = density_at(vp.w, fluid.density, fluid.sound_speed);
    Vec3 pressure = real(2) * acting_pressure(medium, vp.w) * b.wall.slope - rho * b.wall.pull;
    const real out = pressure.dot(b.n);
    if (!medium.tension && out < real(0)) pressure -= out * b.n;  // a wall holds nothing
    return xV.w * pressure;
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t part, Team team) const {
    const WallRange range = wall_range(walls, part, count);
    for (std::uint32_t k = 0; k < walls.by.bodies; ++k) {
      const BodyState& body = bodies.body[walls.body[k]];
      const bool asked = body.force_first != kNone;  // for its wrench
      Vec3 force(0, 0, 0), torque(0, 0, 0);
      const auto touched = [&](std::uint32_t i) {
        if (walls.beside[i] == 0) return false;
        const Tag tag = state.tag[i];
        return tag.is_fluid() && !tag.inactive() && (asked || !tag.asleep());
      };
      const std::uint32_t end = walls.near[part] > 0 ? range.end : range.begin;
      team.for_those(range.begin, end, touched, [&](std::uint32_t i) {
        const Tag tag = state.tag[i];
        const real share = bonds.wall_share(tag, bonds.solid(state, i), walls.body[k]);
        if (!(share > real(0))) return;
        const Passing passing = passing_of(state, medium, *forcing, i);
        const NearBody b = known_body(walls, grid, medium, body, k, i, state.xV[i].xyz(), &passing);
        if (!b.near) return;
        const Vec3 push = share * (pressure_on(i, b) + state.mass[i] * guard_push(i, b, body));
        const Vec3 drag = share * drag_on(i, b);
        force -= push + drag;
        torque -= b.r.cross(push) + b.foot.cross(drag);
        if (body.kind == BodyKind::rigid) torque += share * couple(i, b, body.w);
        if (!tag.asleep()) acceleration[i] = pack(acceleration[i].xyz() + (push + drag) / state.mass[i], 0);
      });
      if (!asked) continue;
      force = team.sum(force);
      torque = team.sum(torque);
      if (team.leader()) walls.by.wrench[part * walls.by.bodies + k] = {force, torque};
    }
  }
};

}  // namespace palp
