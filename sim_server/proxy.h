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

PALP_HD inline Mat3 cross_matrix(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

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

// device: the state of the device at the end of this sub-step.
PALP_HD inline void advance_proxy(BodyState& b, const HandleState<real>& device, const Gains<real>& gains,
                                  const Vec3& gravity, real dt) {
  const Mat3 R = b.q.toRotationMatrix();
  const Mat3 inertia = R * b.inertia * R.transpose();
  const Vec3 r = R * b.handle;
  const Mat3 r_cross = cross_matrix(r);
  // the coupling's force on the handle at the end of the sub-step is F0 - k v_h', with v_h' = v' - [r] w'
  const real k = dt * gains.stiffness + gains.damping;
  const real kr = dt * gains.angular_stiffness + gains.angular_damping;
  const Vec3 F0 = gains.stiffness * (device.x - (b.x + r)) + gains.damping * device.v;
  const Vec3 T0 = gains.angular_stiffness * rotation_between(b.q, device.q) + gains.angular_damping * device.w;
  const Vec3 b1 = b.mass * b.v + dt * (b.force + b.mass * gravity + F0);
  const Vec3 b2 = inertia * b.w + dt * (b.torque - b.w.cross(inertia * b.w) + r.cross(F0) + T0);
  // eliminate v' = (b1 + dt k [r] w') / (m + dt k), then solve 3x3 for w'
  const real m_hat = b.mass + dt * k;
  const Mat3 A = inertia + Mat3::Identity() * (dt * kr) - (dt * k * b.mass / m_hat) * (r_cross * r_cross);
  b.w = A.inverse() * (b2 - (dt * k / m_hat) * r.cross(b1));
  b.v = (b1 + dt * k * r.cross(b.w)) / m_hat;
  const Vec3 v_handle = b.v + b.w.cross(r);
  b.coupling_force = F0 - k * v_handle;
  b.coupling_torque = T0 - kr * b.w;
  // work of the proxy on the coupling: the coupling's force on the device is the opposite of that on the proxy
  b.work[0] -= dt * b.coupling_force.dot(v_handle);
  b.work[1] -= dt * b.coupling_torque.dot(b.w);
  b.x += dt * b.v;
  b.q = rotated(b.q, dt * b.w);
  b.L = inertia * b.w;
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
    HandleState<real> device = p.device;
    device.x += elapsed * device.v;
    device.q = rotated(device.q, elapsed * device.w);
    advance_proxy(b, device, p.gains, gravity, dt);
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
