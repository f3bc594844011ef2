// The proxy: a rigid body whose handle is coupled to a device by the law of idl/coupling.h (paper section 4.1). Its
// step is linearly implicit in the coupling and in its contact with fixed bodies, so that neither adds a stability
// limit of its own, however light the tool and however stiff both are:
//   (M + dt B^ + dt^2 K^) u' + dt A (u' - u) = M u + dt (W_ext + K^ e + B^ u_d)
// A is the resistance of contact (rigid.h), the sum of dt k + c over the points that touch. It multiplies the change of
// u, not u itself, so that a bounce keeps its restitution.
#pragma once

#include "idl/coupling.h"
#include "sim_server/physics/rigid.h"

namespace palp {

// The host's input to a proxy for one haptic step.
struct ProxyInput {
  MotionState<real> device;  // at the start of the step; it moves on with its twist
  Gains<real> gains;
  bool engaged;
  real fastest;  // the largest speed of any of its points that what is around it can take [m/s]
};

// Returns the state of a proxy's handle.
PALP_HD inline MotionState<real> handle_of(const BodyState& b) {
  const Vec3 r = b.q * b.handle;
  return {b.x + r, b.q, b.v + b.w.cross(r), b.w};
}

// Holds a body where it is: a proxy that no hand moves.
PALP_HD inline void hold_body(BodyState& b) {
  b.v.setZero();
  b.w.setZero();
  b.L.setZero();
}

// A proxy's linearly implicit sub-step: the momenta of all forces but those of viscous stages, and the mass that they
// move.
struct ProxyStep {
  CoupledMass mass;
  Vec3 p, l;    // [N s, N m s], l about the centre of mass
  Vec3 r;       // handle from the centre of mass, world axes [m]
  Vec3 F0, T0;  // coupling force and torque on the handle, were the proxy at rest at the end [N, N m]
  real k, kr;   // coefficients of the handle's velocity in them [N s/m, N m s]
};

// Returns the sub-step of a proxy under a force and a torque about its centre. device: the state of the device at the
// end of this sub-step.
PALP_HD inline ProxyStep begin_proxy(const BodyState& b, const Vec3& force, const Vec3& torque,
                                     const MotionState<real>& device, const Gains<real>& gains, const Vec3& gravity,
                                     const Resistance& contact, real dt) {
  const Mat3 R = b.q.toRotationMatrix();
  const Mat3 inertia = R * b.inertia * R.transpose();
  const Vec3 r = R * b.handle;
  ProxyStep s;
  s.r = r;
  // the coupling's force on the handle at the end of the sub-step is F0 - k v_h', with v_h' = v' - [r] w'
  s.k = dt * gains.stiffness + gains.damping;
  s.kr = dt * gains.angular_stiffness + gains.angular_damping;
  s.F0 = gains.stiffness * (device.position - (b.x + r)) + gains.damping * device.linear;
  s.T0 = gains.angular_stiffness * rotation_between(b.q, device.orientation) + gains.angular_damping * device.angular;
  s.p = b.mass * b.v + dt * (force + b.mass * gravity + s.F0 + contact.vv * b.v + contact.vw * b.w);
  s.l = inertia * b.w + dt * (torque - b.w.cross(inertia * b.w) + r.cross(s.F0) + s.T0 + contact.vw.transpose() * b.v +
                              contact.ww * b.w);
  s.mass = coupled_mass(b.mass, inertia, r, dt * s.k, dt * s.kr, contact, dt);
  return s;
}

// Adds a force and a torque about the centre of mass to those of this sub-step.
PALP_HD inline void add_wrench(BodyState& b, const Vec3& force, const Vec3& torque) {
  b.force += force;
  b.torque += torque;
  b.force_sum += force;
  b.torque_sum += torque;
}

// Slows a body down that would move past what is around it can take, which a hand that jumps would else break: nothing
// in a weakly compressible fluid may move at its speed of sound, nor past the particles of a body without touching
// them. What this takes is lost, as by a wave drag.
PALP_HD inline void hold_back(const BodyState& b, real fastest, Vec3& v, Vec3& w) {
  // the radius of a ball with the body's mean moment of inertia
  const real radius = Eigen::numext::sqrt(b.inertia.trace() / (real(1.2) * b.mass));
  const real speed = v.norm() + radius * w.norm();
  if (!(speed > fastest)) return;
  v *= fastest / speed;
  w *= fastest / speed;
}

// Advances a proxy by one sub-step.
PALP_HD inline void advance_proxy(BodyState& b, const MotionState<real>& device, const ProxyInput& input,
                                  const Vec3& gravity, const Resistance& contact, real dt) {
  const Gains<real>& gains = input.gains;
  ProxyStep s = begin_proxy(b, b.force, b.torque, device, gains, gravity, contact, dt);
  Vec3 v, w;
  s.mass.solve(s.p, s.l, v, w);
  const Vec3 force = contact.vv * (v - b.v) + contact.vw * (w - b.w);
  const Vec3 torque = contact.vw.transpose() * (v - b.v) + contact.ww * (w - b.w);
  if ((contact.push - force).dot(contact.push) < real(0)) {
    // contact would pull: the hand takes the tool away
    add_wrench(b, -contact.push, -contact.turn);
    s = begin_proxy(b, b.force, b.torque, device, gains, gravity, no_resistance(), dt);
    s.mass.solve(s.p, s.l, v, w);
  } else {
    add_wrench(b, -force, -torque);
  }
  hold_back(b, input.fastest, v, w);
  b.v = v;
  b.w = w;
  const Mat3 R = b.q.toRotationMatrix();
  b.L = R * b.inertia * R.transpose() * b.w;
  const Vec3 v_handle = b.v + b.w.cross(s.r);
  const Vec3 coupling_force = s.F0 - s.k * v_handle, coupling_torque = s.T0 - s.kr * b.w;
  b.coupling_sum += coupling_force;
  // A tool that creeps by less than half a unit in the last place of its position stays where it is, and does no work.
  const Vec3 from = b.x;
  b.x += dt * b.v;
  const Vec3 gone = b.x - from + dt * b.w.cross(s.r);
  // work of the proxy on the coupling: the coupling's force on the device is the opposite of that on the proxy
  b.work[0] -= coupling_force.dot(gone);
  b.work[1] -= dt * coupling_torque.dot(b.w);
  b.q = rotated(b.q, dt * b.w);
}

// Returns the state of the device some time after the start of the haptic step [s].
PALP_HD inline MotionState<real> device_after(const ProxyInput& p, real elapsed) {
  MotionState<real> device = p.device;
  device.position += elapsed * device.linear;
  device.orientation = rotated(device.orientation, elapsed * device.angular);
  return device;
}

// Returns the resistance of all contact of a body with fixed bodies.
PALP_HD inline Resistance resistance_of(const PairWrenches& contact, std::uint32_t body) {
  Resistance sum = no_resistance();
  if (contact.resistance == nullptr) return sum;
  for (std::uint32_t p = contact.of_body[body]; p < contact.of_body[body + 1]; ++p) {
    const std::uint32_t pair = contact.part[p] / 2;
    if (pair >= contact.rigid_pairs) break;
    if (contact.held[pair] == kNone || !contact.wrench[pair].near) continue;
    const Resistance& of_pair = contact.resistance[contact.held[pair]];
    sum.vv += of_pair.vv;
    sum.vw += of_pair.vw;
    sum.ww += of_pair.ww;
    sum.push += of_pair.push;
    sum.turn += of_pair.turn;
  }
  return sum;
}

// Advances free bodies and proxies; one thread a body. elapsed: time from the start of the haptic step to the end of
// this sub-step [s].
struct AdvanceBodies {
  BodyState* body;
  PairWrenches contact;
  const std::uint32_t* moving;  // indices of the rigid bodies
  const ProxyInput* proxy;
  const Forcing* forcing;
  CellGrid grid;
  real dt, elapsed;

  PALP_HD void operator()(std::uint32_t k) const {
    BodyState& b = body[moving[k]];
    if (b.proxy < 0) return advance_free_body(b, surroundings(grid, *forcing, b.x, dt), dt);
    const Vec3 gravity = forcing->gravity + forcing->body_force;
    const ProxyInput& p = proxy[b.proxy];
    if (!p.engaged) return hold_body(b);
    advance_proxy(b, device_after(p, elapsed), p, gravity, resistance_of(contact, moving[k]), dt);
  }
};

// Clears the sums over the sub-steps of a haptic step.
struct BeginStep {
  BodyState* body;
  PALP_HD void operator()(std::uint32_t k) const {
    body[k].force_sum.setZero();
    body[k].torque_sum.setZero();
    body[k].coupling_sum.setZero();
    body[k].work[0] = body[k].work[1] = 0;
  }
};

}  // namespace palp
