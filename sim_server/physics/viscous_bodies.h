// Rigid bodies at the start of the viscous stages (physics/viscosity.h): the change of each one's motion by all other
// forces, the mass that viscosity moves, which includes the coupling of a body that a hand holds, and its limit l.
#pragma once

#include "sim_server/physics/proxy.h"
#include "sim_server/physics/viscosity.h"

namespace palp {

// Returns a bound on K / m of a body that moves and turns: with velocities scaled by the roots of mass and inertia, the
// larger one of the bounds of translation and rotation, plus that of what couples the two. moment = sum K r,
// turning = sum K (r^2 - r r^T).
template <class M, class V, class S>
PALP_HD inline S body_viscous_rate(S mass, const M& inverse_inertia, S sum, const V& moment, const M& turning) {
  const S lightest = inverse_inertia.cwiseAbs().rowwise().sum().maxCoeff();
  const S turns = (inverse_inertia * turning).cwiseAbs().rowwise().sum().maxCoeff();
  const S moves = sum / mass;
  return (moves > turns ? moves : turns) + moment.norm() * Eigen::numext::sqrt(lightest / mass);
}

// Sets the state of each rigid body for the first stage; one team a body.
struct BeginViscousBodies {
  BodyViews bodies;
  const std::uint32_t* rigid;
  const ProxyInput* proxy;
  const Forcing* forcing;
  ViscosityViews viscosity;
  WallWrenches walls;
  real dt, elapsed, reach;

  template <class Team>
  PALP_HD void operator()(std::uint32_t k, Team team) const {
    BodyState body = bodies.body[rigid[k]];
    const Mat3 R = body.q.toRotationMatrix();
    Vec3 force(0, 0, 0), torque(0, 0, 0);
    DragMoments drag = no_moments();
    for (std::uint32_t p = body.force_first + team.lane(); p < body.force_first + body.count; p += team.size()) {
      const Vec3 f = bodies.force[p].xyz(), r = R * bodies.local[p].xyz();
      const real K = viscosity.solid[p].w;
      force += f;
      torque += r.cross(f);
      drag.add(K, r);
    }
    if (walls.place != nullptr && walls.place[rigid[k]] != kNone)
      for (std::uint32_t p = team.lane(); p < walls.parts; p += team.size()) {
        const std::uint32_t at = p * walls.bodies + walls.place[rigid[k]];
        force += walls.wrench[at].force;
        torque += walls.wrench[at].torque;
        const DragMoments& one = viscosity.drag_moments[at];
        drag = {drag.sum + one.sum, drag.moment + one.moment, drag.squares + one.squares, drag.products + one.products};
      }
    body.force = team.sum(force);
    body.torque = team.sum(torque);
    const real sum = team.sum(drag.sum);
    const Vec3 moment = team.sum(drag.moment), squares = team.sum(drag.squares), products = team.sum(drag.products);
    if (!team.leader()) return;
    const Mat3 turning = DragMoments{sum, moment, squares, products}.turning();
    ViscousBody& b = viscosity.body[rigid[k]];
    begin(body, b);
    const real rate = dt * body_viscous_rate(body.mass, world_inverse_inertia(body, body.q), sum, moment, turning);
    b.limit = rate > reach ? reach / rate : real(1);
  }

  PALP_HD void begin(const BodyState& body, ViscousBody& b) const {
    b.dt = dt;
    Vec3 v(0, 0, 0), w(0, 0, 0);
    b.v[0] = body.v;
    b.w[0] = body.w;
    const Vec3 gravity = forcing->gravity + forcing->body_force;
    if (body.proxy < 0) {
      const Mat3 R = body.q.toRotationMatrix();
      b.mass = {Mat3::Identity() / body.mass, Mat3::Zero(), world_inverse_inertia(body, body.q)};
      const Vec3 turn = body.torque - body.w.cross(R * body.inertia * R.transpose() * body.w);
      b.mass.solve(dt * (body.force + body.mass * gravity), dt * turn, v, w);
      b.dv = v;
      b.dw = w;
    } else if (proxy[body.proxy].engaged) {
      const ProxyInput& p = proxy[body.proxy];
      const ProxyStep s =
          begin_proxy(body, body.force, body.torque, device_after(p, elapsed), p.gains, gravity, no_resistance(), dt);
      b.mass = s.mass;
      s.mass.solve(s.p, s.l, v, w);
      b.dv = v - body.v;
      b.dw = w - body.w;
    } else {
      // held: nothing moves it
      b.mass = {Mat3::Zero(), Mat3::Zero(), Mat3::Zero()};
      b.v[0] = b.w[0] = b.dv = b.dw = Vec3(0, 0, 0);
    }
    b.v[1] = b.v[0];
    b.w[1] = b.w[0];
  }
};

}  // namespace palp
