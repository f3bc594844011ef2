// The share of the coupling's stiffness that a contact has: the part of the wrench that the bridge may render at once,
// without waiting for the server (haptic_bridge/loop/local_model.h). Host only, no allocation, no throw.
#pragma once

#include <Eigen/Core>

namespace palp {

// 1 for a rigid contact, about ke / (K + ke) for an elastic one, 0 in free space and in fluid. The wrench by which the
// coupling would change were the proxy held, D, is compared with the one by which the contact changes, dF, both against
// their own slow means: the blend is the least squares' L in dF = -L D over some hundredths of a second. D holds the
// damper as well as the spring, so that a rigid contact gives 1 however the hand moves; neither the lag of the proxy's
// mass nor the jitter of a link changes a contact. Where nothing touches, the memory begins anew, as if the contact had
// just stopped the proxy: the motion before tells nothing of the contact.
class ContactBlend {
 public:
  // Returns the share by which the slow mean of a device's state moves towards the newest one in a step [s].
  static double share_of_slow_mean(double step);

  // Updates the blend with one step of length `step` [s] and returns it, 0..1. force: of the contact on the proxy;
  // demand: D, against the slow mean; held: force of coupling and weight on a proxy at rest; min_demand: the smallest D
  // that tells anything. All in N, or all in N m.
  double update(const Eigen::Vector3d& force, const Eigen::Vector3d& demand, const Eigen::Vector3d& held,
                double min_demand, double step);

 private:
  Eigen::Vector3d slow_force_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d before_ = Eigen::Vector3d::Zero();  // the part of D from before the contact
  double answered_ = 0, asked_ = 0;                   // means of -dF . D and of D . D
  double value_ = 0;
};

}  // namespace palp
