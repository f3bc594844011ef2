// What the host's side of a step does with the motion of devices and tools.
#pragma once

#include "sim_server/solver/simulation.h"

namespace palp {

// v, shortened to a length if it is longer.
inline Eigen::Vector3d at_most(const Eigen::Vector3d& v, double most) {
  const double n = v.norm();
  return n > most ? Eigen::Vector3d(v * (most / n)) : v;
}

// A state after dt [s], moving on with its twist, as the sub-steps see it.
inline RigidState moved_on(RigidState s, double dt) {
  s.position += dt * s.linear;
  const double angle = s.angular.norm() * dt;
  if (angle > 0) s.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, s.angular.normalized())) * s.orientation;
  return s;
}

}  // namespace palp
