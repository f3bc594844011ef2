// Conversions between what travels on the bus (idl/messages.h) and what is computed with (idl/coupling.h), and the
// checks on both. Every function here: no allocation, no lock, no throw.
#pragma once

#include <array>
#include <cmath>

#include "idl/coupling.h"
#include "idl/messages.h"

namespace palp {

inline Eigen::Vector3d to_vector(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }
inline Eigen::Quaterniond to_quaternion(const std::array<double, 4>& a) { return {a[3], a[0], a[1], a[2]}; }
inline std::array<double, 3> to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// Orientations are made exact unit quaternions in both directions: on the bus they may be off by kUnitTolerance, and a
// state that was computed in single precision is off by its rounding.
inline PoseD to_pose(const RigidState& s) {
  const Eigen::Quaterniond q = s.orientation.normalized();
  return {to_array(s.position), {q.x(), q.y(), q.z(), q.w()}};
}
inline TwistD to_twist(const RigidState& s) { return {to_array(s.linear), to_array(s.angular)}; }
inline RigidState to_state(const PoseD& pose, const TwistD& twist) {
  return {to_vector(pose.position), to_quaternion(pose.orientation).normalized(), to_vector(twist.linear),
          to_vector(twist.angular)};
}

inline WrenchD to_message(const Wrench<double>& w) { return {to_array(w.force), to_array(w.torque)}; }
inline Wrench<double> to_wrench(const WrenchD& w) { return {to_vector(w.force), to_vector(w.torque)}; }
inline Wrench<double> zero_wrench() { return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}; }

inline RigidState at_rest(const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation) {
  return {position, orientation, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
}

inline bool is_finite(const Eigen::Vector3d& v) {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}
inline bool is_finite(const Eigen::Quaterniond& q) {
  return is_finite(Eigen::Vector3d(q.vec())) && std::isfinite(q.w());
}
inline bool is_finite(const Wrench<double>& w) { return is_finite(w.force) && is_finite(w.torque); }
inline bool is_finite(const RigidState& s) {
  return is_finite(s.position) && is_finite(s.orientation) && is_finite(s.linear) && is_finite(s.angular);
}
inline bool is_finite(const CouplingGains& g) {
  return std::isfinite(g.stiffness) && std::isfinite(g.damping) && std::isfinite(g.angular_stiffness) &&
         std::isfinite(g.angular_damping);
}

// A quaternion further than this from unit length is not an orientation.
inline bool is_unit(const Eigen::Quaterniond& q) {
  return is_finite(q) && std::abs(q.coeffs().stableNorm() - 1) <= kUnitTolerance;
}

}  // namespace palp
