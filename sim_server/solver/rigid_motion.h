// Functions of the host on the motion of devices, tools and rigid bodies.
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

// The momenta and energy of a rigid body as a whole, world axes.
struct RigidMomenta {
  Eigen::Vector3d center;    // of mass [m]
  Eigen::Vector3d momentum;  // [N s]
  Eigen::Vector3d angular;   // about the origin [N m s]
  double kinetic;            // [J]
};

inline RigidMomenta momenta_of(const Body& body, const RigidState& state) {
  const Eigen::Vector3d arm = state.orientation * body.center, v = state.linear + state.angular.cross(arm);
  const Eigen::Vector3d spin = state.orientation.conjugate() * state.angular, turn = body.inertia * spin;
  const Eigen::Vector3d center = state.position + arm, momentum = body.mass * v;
  return {center, momentum, center.cross(momentum) + state.orientation * turn,
          body.mass / 2 * v.squaredNorm() + spin.dot(turn) / 2};
}

}  // namespace palp
