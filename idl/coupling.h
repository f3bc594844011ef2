// The virtual coupling law: a spring and a damper, linear and angular, between the handle of a proxy and the device.
// The server integrates the proxy with it and the bridge renders it, so both call this one function (haptics: Colgate,
// Stanley & Brown 1995; rotation vector as in McNeely, Puterbaugh & Troy 1999). Pure, host and device.
#pragma once

#include <cmath>

#include <Eigen/Geometry>

#include "idl/gains.h"

#if defined(__CUDACC__) && !defined(PALP_HD)
#define PALP_HD __host__ __device__
#elif !defined(PALP_HD)
#define PALP_HD
#endif

namespace palp {

// Past this angle [rad] the rotation vector is held at this length: its direction jumps at pi.
inline constexpr double kMaxCouplingAngle = 2.5;

// Pose and twist of a point that moves with a rigid body: a handle, or the origin of a body's frame. World frame.
template <class S>
struct MotionState {
  Eigen::Matrix<S, 3, 1> position = Eigen::Matrix<S, 3, 1>::Zero();  // [m]
  Eigen::Quaternion<S> orientation = Eigen::Quaternion<S>::Identity();
  Eigen::Matrix<S, 3, 1> linear = Eigen::Matrix<S, 3, 1>::Zero();   // velocity of the point [m/s]
  Eigen::Matrix<S, 3, 1> angular = Eigen::Matrix<S, 3, 1>::Zero();  // angular velocity, world axes [rad/s]

  template <class T>
  MotionState<T> cast() const {
    return {position.template cast<T>(), orientation.template cast<T>(), linear.template cast<T>(),
            angular.template cast<T>()};
  }
};

// Hosts compute with states in double precision, on both ends of the link.
using RigidState = MotionState<double>;

template <class S>
struct Wrench {
  Eigen::Matrix<S, 3, 1> force;   // [N]
  Eigen::Matrix<S, 3, 1> torque;  // [N m], about the handle
};

// Returns the rotation vector [rad] of to * from^-1, the shorter way round.
template <class S>
PALP_HD inline Eigen::Matrix<S, 3, 1> rotation_between(const Eigen::Quaternion<S>& from,
                                                       const Eigen::Quaternion<S>& to) {
  Eigen::Quaternion<S> e = to * from.conjugate();
  if (e.w() < S(0)) e.coeffs() = -e.coeffs();
  const S s = e.vec().norm();
  if (s < S(1e-6)) return S(2) * e.vec();
  using std::atan2;
  S angle = S(2) * atan2(s, e.w());
  if (angle > S(kMaxCouplingAngle)) angle = S(kMaxCouplingAngle);
  return (angle / s) * e.vec();
}

// Returns the rotation by the length [rad] of r about its direction: the way back from rotation_between. Host only, no
// allocation, no lock, no throw.
inline Eigen::Quaterniond rotation_by(const Eigen::Vector3d& r) {
  const double angle = r.norm();
  if (angle < 1e-12) return Eigen::Quaterniond(1, r.x() / 2, r.y() / 2, r.z() / 2).normalized();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, r / angle));
}

// Returns the wrench of the coupling on the device; the proxy receives its opposite. World frame, about the handle.
template <class S>
PALP_HD inline Wrench<S> coupling_wrench(const Gains<S>& k, const MotionState<S>& device, const MotionState<S>& proxy) {
  return {k.stiffness * (proxy.position - device.position) + k.damping * (proxy.linear - device.linear),
          k.angular_stiffness * rotation_between(device.orientation, proxy.orientation) +
              k.angular_damping * (proxy.angular - device.angular)};
}

}  // namespace palp
