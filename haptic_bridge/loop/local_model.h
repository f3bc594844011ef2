// The local model is what the bridge renders between two samples of the server: the wrench of the newest sample,
// corrected to first order for what the device has done since (intermediate representation: Adachi, Kumano & Ogino
// 1995; Mark et al. 1996).
//  W = W0 - L [K (x - x0) + B (v - v0)], and the same for rotation with rotation vectors
// With L = 1 (rigid contact) this is the spring to the proxy, held here; with L = 0 it is the server's wrench, held. No
// allocation, no lock, no throw.
#pragma once

#include "haptic_bridge/loop/force_limits.h"
#include "idl/convert.h"

namespace palp {

struct LocalModel {
  Wrench<double> wrench;  // W0, on the device, about the handle
  RigidState device;      // the device state that W0 was computed from
  CouplingGains gains;
  double blend_linear = 0;  // L, 0..1
  double blend_angular = 0;
};

// The sample must have been judged sound (sample_gate.h).
inline LocalModel local_model(const ProxySample& s) {
  return {to_wrench(s.wrench), to_state(s.device_pose, s.device_twist), s.gains, s.blend[0], s.blend[1]};
}

inline Wrench<double> evaluate(const LocalModel& m, const RigidState& d) {
  const Eigen::Vector3d pull =
      m.gains.stiffness * (d.position - m.device.position) + m.gains.damping * (d.linear - m.device.linear);
  const Eigen::Vector3d twist = m.gains.angular_stiffness * rotation_between(m.device.orientation, d.orientation) +
                                m.gains.angular_damping * (d.angular - m.device.angular);
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
  void change(const LocalModel& m, const RigidState& device) {
    const Wrench<double> shown = at(device), fresh = evaluate(m, device);
    residual_ = {shown.force - fresh.force, shown.torque - fresh.torque};
    model_ = m;
  }
  Wrench<double> at(const RigidState& device) const {
    const Wrench<double> w = evaluate(model_, device);
    return {w.force + residual_.force, w.torque + residual_.torque};
  }
  // Lets the residual decay; to be called once a tick.
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
