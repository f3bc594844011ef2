// Functions of the host's side of a step on the motion of devices and tools.
#pragma once

#include "sim_server/solver/simulation.h"

namespace palp {

// Returns v, shortened to a length if it is longer.
inline Eigen::Vector3d clamp_norm(const Eigen::Vector3d& v, double length) {
  const double n = v.norm();
  return n > length ? Eigen::Vector3d(v * (length / n)) : v;
}

// Returns a state extrapolated with its twist by dt [s], as the sub-steps move a device.
inline RigidState extrapolate(RigidState s, double dt) {
  s.position += dt * s.linear;
  const double angle = s.angular.norm() * dt;
  if (angle > 0) s.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, s.angular.normalized())) * s.orientation;
  return s;
}

}  // namespace palp
