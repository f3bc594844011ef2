// A rotation vector as a rotation: the way back from rotation_between (idl/coupling.h). No allocation, no lock, no
// throw.
#pragma once

#include <Eigen/Geometry>

namespace palp {

// By r's length [rad] about its direction.
inline Eigen::Quaterniond rotation_by(const Eigen::Vector3d& r) {
  const double angle = r.norm();
  if (angle < 1e-12) return Eigen::Quaterniond(1, r.x() / 2, r.y() / 2, r.z() / 2).normalized();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, r / angle));
}

}  // namespace palp
