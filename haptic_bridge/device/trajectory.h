// A path of poses through time: keyframes joined either by a smooth curve through them (Catmull-Rom tangents) or by
// minimum-jerk moves that rest at each (Flash & Hogan 1985). Position and orientation, with the exact twist of the
// curve.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

#include "idl/coupling.h"

namespace palp {

struct Keyframe {
  double time = 0;                              // [s]
  Eigen::Vector3d x = Eigen::Vector3d::Zero();  // [m]
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
};

enum class Interpolation { catmull_rom, minimum_jerk };

class Trajectory {
 public:
  // Keyframes in order of strictly increasing time, at least one, unit quaternions, consecutive orientations less than
  // kMaxCouplingAngle apart. loop: after the last keyframe comes the first, whose pose must be the same.
  // Throws std::invalid_argument naming the keyframe (counted from 1) that breaks a rule.
  Trajectory(std::vector<Keyframe> keyframes, Interpolation interpolation, bool loop);

  // Pose and twist at a time [s]; before the first keyframe its pose, after the last the last one's, at rest.
  // No allocation, no lock, no throw.
  RigidState at(double time) const noexcept;
  double duration() const { return keyframes_.back().time - keyframes_.front().time; }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }

 private:
  struct Tangent {
    Eigen::Vector3d v, w;
  };
  void find_tangents();

  std::vector<Keyframe> keyframes_;
  std::vector<Tangent> tangents_;  // empty for minimum jerk
  bool loop_;
};

}  // namespace palp
