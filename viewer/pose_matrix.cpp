#include "viewer/pose_matrix.h"

#include <cmath>

namespace palp {

bool pose_matrix(const PoseD& pose, osg::Matrixd& out) {
  const auto& p = pose.position;
  const auto& q = pose.orientation;
  const double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  const double sum = p[0] + p[1] + p[2] + norm2;
  if (!std::isfinite(sum) || norm2 < 1e-6) return false;
  out = osg::Matrixd::rotate(osg::Quat(q[0], q[1], q[2], q[3])) * osg::Matrixd::translate(p[0], p[1], p[2]);
  return true;
}

}  // namespace palp
