// Poses that the tests of the devices share.
#pragma once

#include "haptic_bridge/loop/local_model.h"

namespace palp::test {

inline const RigidState kOrigin = at_rest(Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());

inline Eigen::Quaterniond turn(double angle, const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

}  // namespace palp::test
