// What the bridge renders between two samples of the server: the wrench of the newest sample, corrected to first order
// for what the device has done since (intermediate representation: Adachi, Kumano & Ogino 1995; Mark et al. 1996).
//   W = W0 - L [K (x - x0) + B (v - v0)], and the same for rotation with rotation vectors
// With L = 1 (rigid contact) this is the spring to the proxy, held here; with L = 0 it is the server's wrench, held.
// No allocation, no lock, no throw.
#pragma once

#include "haptic_bridge/loop/filters.h"
#include "idl/coupling.h"
#include "idl/messages.h"

namespace palp {

struct LocalModel {
  Wrench<double> wrench;       // W0, on the device, about the handle
  HandleState<double> device;  // the device state that W0 was computed from
  Gains<double> gains;
  double blend_linear = 0;  // L, 0..1
  double blend_angular = 0;
};

inline Eigen::Vector3d to_vector(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }
inline Eigen::Quaterniond to_quaternion(const std::array<double, 4>& a) { return {a[3], a[0], a[1], a[2]}; }
inline HandleState<double> to_handle(const PoseD& pose, const TwistD& twist) {
  return {to_vector(pose.position), to_quaternion(pose.orientation), to_vector(twist.linear), to_vector(twist.angular)};
}
inline HandleState<double> at_rest(const Eigen::Vector3d& x, const Eigen::Quaterniond& q) {
  return {x, q, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
}
inline PoseD to_pose(const HandleState<double>& h) {
  return {{h.x.x(), h.x.y(), h.x.z()}, {h.q.x(), h.q.y(), h.q.z(), h.q.w()}};
}
inline TwistD to_twist(const HandleState<double>& h) {
  return {{h.v.x(), h.v.y(), h.v.z()}, {h.w.x(), h.w.y(), h.w.z()}};
}

// The sample must have been judged sound (sample_gate.h).
inline LocalModel local_model(const ProxySample& s) {
  LocalModel m{{to_vector(s.wrench.force), to_vector(s.wrench.torque)},
               to_handle(s.device_pose, s.device_twist),
               {s.gains.stiffness, s.gains.damping, s.gains.angular_stiffness, s.gains.angular_damping},
               s.blend[0],
               s.blend[1]};
  m.device.q.normalize();
  return m;
}

inline Wrench<double> evaluate(const LocalModel& m, const HandleState<double>& d) {
  const Eigen::Vector3d pull = m.gains.stiffness * (d.x - m.device.x) + m.gains.damping * (d.v - m.device.v);
  const Eigen::Vector3d twist =
      m.gains.angular_stiffness * rotation_between(m.device.q, d.q) + m.gains.angular_damping * (d.w - m.device.w);
  return {m.wrench.force - m.blend_linear * pull, m.wrench.torque - m.blend_angular * twist};
}

// A local model that changes without a step: what a new sample would change at once is carried as a residual that
// decays with a time constant (VRPN calls it recovery).
class BlendedModel {
 public:
  // decay: factor on the residual per tick, 0 (no blend) .. 1.
  explicit BlendedModel(double decay) : decay_(decay) {}

  // Starts from a sample without any memory of an earlier one.
  void reset(const LocalModel& m) {
    model_ = m;
    residual_ = zero_wrench();
  }
  // Goes over to a new sample; device: the state of this tick.
  void change(const LocalModel& m, const HandleState<double>& device) {
    const Wrench<double> shown = at(device), fresh = evaluate(m, device);
    residual_ = {shown.force - fresh.force, shown.torque - fresh.torque};
    model_ = m;
  }
  Wrench<double> at(const HandleState<double>& device) const {
    const Wrench<double> w = evaluate(model_, device);
    return {w.force + residual_.force, w.torque + residual_.torque};
  }
  // Once a tick.
  void decay() {
    residual_.force *= decay_;
    residual_.torque *= decay_;
  }
  const LocalModel& model() const { return model_; }

 private:
  double decay_;
  LocalModel model_{zero_wrench(), at_rest(Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()), {0, 0, 0, 0}};
  Wrench<double> residual_ = zero_wrench();
};

}  // namespace palp
