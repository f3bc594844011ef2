// How much of the coupling's stiffness a contact answers with: the part of the wrench that the bridge may render at
// once, without waiting for the server (haptic_bridge/loop/local_model.h). Host only, no allocation, no throw.
#pragma once

#include <Eigen/Core>

namespace palp {

// 1 for a rigid contact, about ke / (K + ke) for an elastic one, 0 in free space and in fluid. The wrench by which the
// coupling would change were the proxy held, D, is compared with the one by which the contact changes, dF, both against
// their own slow means: the blend is the least squares' L in dF = -L D over some hundredths of a second. D holds the
// damper as well as the spring, so that a rigid contact gives 1 however the hand moves; what the proxy's mass makes it
// lag, and what a link makes of the device's motion, changes no contact. Where nothing touches, the memory begins anew,
// from a proxy that the contact has just stopped: of how it came, the contact tells nothing.
class Blend {
 public:
  // How far the slow mean of a device's state moves towards the newest one in a step [s].
  static double share_of_slow_mean(double step);

  // One step [s]. force: of the contact on the proxy; demand: D, against the slow mean; held: what the coupling and the
  // weight would press the proxy with did it stand still; least: of D that tells anything. All N, or all N m. Returns
  // the blend, 0..1.
  double update(const Eigen::Vector3d& force, const Eigen::Vector3d& demand, const Eigen::Vector3d& held, double least,
                double step);

 private:
  Eigen::Vector3d slow_force_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d before_ = Eigen::Vector3d::Zero();  // of D, what was before the contact
  double answered_ = 0, asked_ = 0;                   // means of -dF . D and of D . D
  double value_ = 0;
};

}  // namespace palp
