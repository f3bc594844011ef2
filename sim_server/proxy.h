// The proxy: a rigid body whose handle is coupled to a device by the law of idl/coupling.h (paper section 4.1). Its
// step is linearly implicit in the coupling, so the coupling adds no stability limit of its own:
//   (M + dt B^ + dt^2 K^) u' = M u + dt (W_ext + K^ e + B^ u_d)
#pragma once

#include "idl/coupling.h"
#include "sim_server/physics/rigid.h"

namespace palp {

// What the host gives a proxy for one haptic step.
struct ProxyInput {
  HandleState<real> device;  // at the start of the step; it moves on with its twist
  Gains<real> gains;
  bool engaged;
};

PALP_HD inline HandleState<real> handle_of(const BodyState& b) {
  const Vec3 r = b.q * b.handle;
  return {b.x + r, b.q, b.v + b.w.cross(r), b.w};
}

// A body without its hand is held where it is.
PALP_HD inline void hold_body(BodyState& b) {
  b.v.setZero();
  b.w.setZero();
  b.L.setZero();
  b.coupling_force.setZero();
  b.coupling_torque.setZero();
}

// A proxy's linearly implicit sub-step: the momenta that everything but viscous stages adds up to, and what they move.
struct ProxyStep {
  CoupledMass mass;
  Vec3 p, l;    // [N s, N m s], l about the centre of mass
  Vec3 F0, T0;  // of the coupling on the handle, were the proxy at rest at the end [N, N m]
  real k, kr;   // what its motion takes from them [N s/m, N m s]
};

// device: the state of the device at the end of this sub-step.
PALP_HD inline ProxyStep begin_proxy(const BodyState& b, const HandleState<real>& device, const Gains<real>& gains,
                                     const Vec3& gravity, real dt) {
  const Mat3 R = b.q.toRotationMatrix();
  const Mat3 inertia = R * b.inertia * R.transpose();
  const Vec3 r = R * b.handle;
  ProxyStep s;
  // the coupling's force on the handle at the end of the sub-step is F0 - k v_h', with v_h' = v' - [r] w'
  s.k = dt * gains.stiffness + gains.damping;
  s.kr = dt * gains.angular_stiffness + gains.angular_damping;
  s.F0 = gains.stiffness * (device.x - (b.x + r)) + gains.damping * device.v;
  s.T0 = gains.angular_stiffness * rotation_between(b.q, device.q) + gains.angular_damping * device.w;
  s.p = b.mass * b.v + dt * (b.force + b.mass * gravity + s.F0);
  s.l = inertia * b.w + dt * (b.torque - b.w.cross(inertia * b.w) + r.cross(s.F0) + s.T0);
  s.mass = coupled_mass(b.mass, inertia, r, dt * s.k, dt * s.kr);
  return s;
}

PALP_HD inline void advance_proxy(BodyState& b, const HandleState<real>& device, const Gains<real>& gains,
                                  const Vec3& gravity, real dt) {
  const ProxyStep s = begin_proxy(b, device, gains, gravity, dt);
  s.mass.solve(s.p, s.l, b.v, b.w);
  const Mat3 R = b.q.toRotationMatrix();
  b.L = R * b.inertia * R.transpose() * b.w;
  const Vec3 v_handle = b.v + b.w.cross(s.mass.r);
  b.coupling_force = s.F0 - s.k * v_handle;
  b.coupling_torque = s.T0 - s.kr * b.w;
  // work of the proxy on the coupling: the coupling's force on the device is the opposite of that on the proxy
  b.work[0] -= dt * b.coupling_force.dot(v_handle);
  b.work[1] -= dt * b.coupling_torque.dot(b.w);
  b.x += dt * b.v;
  b.q = rotated(b.q, dt * b.w);
}

PALP_HD inline HandleState<real> device_after(const ProxyInput& p, real elapsed) {
  HandleState<real> device = p.device;
  device.x += elapsed * device.v;
  device.q = rotated(device.q, elapsed * device.w);
  return device;
}

// One thread a body. elapsed: sub-step end since the start of the haptic step [s].
struct AdvanceBodies {
  BodyState* body;
  const std::uint32_t* moving;  // indices of the rigid bodies
  const ProxyInput* proxy;
  const Forcing* forcing;
  real dt, elapsed;

  PALP_HD void operator()(std::uint32_t k) const {
    BodyState& b = body[moving[k]];
    const Vec3 gravity = forcing->gravity + forcing->body_force;
    if (b.proxy < 0) return advance_free_body(b, gravity, dt);
    const ProxyInput& p = proxy[b.proxy];
    if (!p.engaged) return hold_body(b);
    advance_proxy(b, device_after(p, elapsed), p.gains, gravity, dt);
  }
};

// Clears what is summed over the sub-steps of a haptic step.
struct BeginStep {
  BodyState* body;
  PALP_HD void operator()(std::uint32_t k) const {
    body[k].force_sum.setZero();
    body[k].torque_sum.setZero();
    body[k].work[0] = body[k].work[1] = 0;
  }
};

}  // namespace palp
