// The virtual coupling law: a spring and a damper, linear and angular, between the handle of a proxy and the device.
// The server integrates the proxy with it and the bridge renders it, so both call this one function (haptics: Colgate,
// Stanley & Brown 1995; rotation vector as in McNeely, Puterbaugh & Troy 1999). Pure, host and device.
#pragma once

#include <cmath>

#include <Eigen/Geometry>

#if defined(__CUDACC__) && !defined(PALP_HD)
#define PALP_HD __host__ __device__
#elif !defined(PALP_HD)
#define PALP_HD
#endif

namespace palp {

// Past this angle [rad] the rotation vector is held at this length: its direction jumps at pi.
inline constexpr double kMaxCouplingAngle = 2.5;

template <class S>
struct HandleState {
  Eigen::Matrix<S, 3, 1> x;  // position [m]
  Eigen::Quaternion<S> q;    // orientation
  Eigen::Matrix<S, 3, 1> v;  // velocity of the handle's point [m/s]
  Eigen::Matrix<S, 3, 1> w;  // angular velocity, world frame [rad/s]
};

template <class S>
struct Gains {
  S stiffness;          // [N/m]
  S damping;            // [N s/m]
  S angular_stiffness;  // [N m/rad]
  S angular_damping;    // [N m s/rad]
};

template <class S>
struct Wrench {
  Eigen::Matrix<S, 3, 1> force;   // [N]
  Eigen::Matrix<S, 3, 1> torque;  // [N m], about the handle
};

// Rotation vector [rad] of to * from^-1, the shorter way round.
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

// The wrench of the coupling on the device; the proxy receives its opposite. World frame, about the handle.
template <class S>
PALP_HD inline Wrench<S> coupling_wrench(const Gains<S>& k, const HandleState<S>& device, const HandleState<S>& proxy) {
  return {k.stiffness * (proxy.x - device.x) + k.damping * (proxy.v - device.v),
          k.angular_stiffness * rotation_between(device.q, proxy.q) + k.angular_damping * (proxy.w - device.w)};
}

}  // namespace palp
