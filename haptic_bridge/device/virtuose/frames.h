// Between the arm's frame and numbers (float; X towards the operator, Y to the operator's right, Z up) and the world's
// (double; z up, turned about as the profile says). Only turned, never scaled: both are right-handed and in SI units.
// Pure; no allocation, no lock, no throw.
#pragma once

#include <array>

#include <Eigen/Geometry>

#include "idl/coupling.h"

namespace palp {

using ArmPose = std::array<float, 7>;    // x y z qx qy qz qw
using ArmVector = std::array<float, 6>;  // linear, angular

inline constexpr ArmPose kArmOrigin{0, 0, 0, 0, 0, 0, 1};

// Whoever looks along world +y, as at the viewer's picture: X is world -y, Y is +x, Z is +z.
inline Eigen::Matrix3d default_arm_axes() {
  Eigen::Matrix3d m;
  m.col(0) = -Eigen::Vector3d::UnitY();
  m.col(1) = Eigen::Vector3d::UnitX();
  m.col(2) = Eigen::Vector3d::UnitZ();
  return m;
}

class ArmFrame {
 public:
  // axes: column i is the arm's axis i in the world; a rotation. start: where in the world the handle is taken to be
  // when place is called: the arm's own origin means nothing to a scene.
  ArmFrame(const Eigen::Matrix3d& axes, const RigidState& start)
      : axes_(axes), turn_(axes), start_(start), x_placed_(Eigen::Vector3d::Zero()), q_placed_(start.orientation) {
    q_placed_.setIdentity();
  }

  void place(const ArmPose& pose) {
    x_placed_ = position(pose);
    q_placed_ = orientation(pose);
  }

  RigidState to_world(const ArmPose& pose, const ArmVector& speed) const {
    const Eigen::Quaterniond since = orientation(pose) * q_placed_.conjugate();
    return {start_.position + axes_ * (position(pose) - x_placed_),
            (turn_ * since * turn_.conjugate() * start_.orientation).normalized(), axes_ * linear(speed),
            axes_ * angular(speed)};
  }

  ArmPose to_arm(const Eigen::Vector3d& x, const Eigen::Quaterniond& q) const {
    const Eigen::Vector3d p = x_placed_ + axes_.transpose() * (x - start_.position);
    const Eigen::Quaterniond r =
        (turn_.conjugate() * q * start_.orientation.conjugate() * turn_ * q_placed_).normalized();
    return {as_float(p.x()), as_float(p.y()), as_float(p.z()), as_float(r.x()),
            as_float(r.y()), as_float(r.z()), as_float(r.w())};
  }

  // Linear and angular parts are turned alike: force and torque, velocity and angular velocity.
  ArmVector to_arm(const Eigen::Vector3d& linear_part, const Eigen::Vector3d& angular_part) const {
    const Eigen::Vector3d a = axes_.transpose() * linear_part, b = axes_.transpose() * angular_part;
    return {as_float(a.x()), as_float(a.y()), as_float(a.z()), as_float(b.x()), as_float(b.y()), as_float(b.z())};
  }

  static Eigen::Quaterniond orientation(const ArmPose& p) {
    return Eigen::Quaterniond(p[6], p[3], p[4], p[5]).normalized();
  }

 private:
  static float as_float(double value) { return static_cast<float>(value); }
  static Eigen::Vector3d position(const ArmPose& p) { return {p[0], p[1], p[2]}; }
  static Eigen::Vector3d linear(const ArmVector& v) { return {v[0], v[1], v[2]}; }
  static Eigen::Vector3d angular(const ArmVector& v) { return {v[3], v[4], v[5]}; }

  Eigen::Matrix3d axes_;
  Eigen::Quaterniond turn_;
  RigidState start_;
  Eigen::Vector3d x_placed_;
  Eigen::Quaterniond q_placed_;
};

}  // namespace palp
