// Rotations of rigid bodies and of neighbourhoods.
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

// q turned by a rotation vector in world axes [rad].
PALP_HD inline Quat rotated(const Quat& q, const Vec3& rotation) {
  const real angle = rotation.norm();
  const real half = real(0.5) * angle;
  const real s = angle > real(1e-6) ? Eigen::numext::sin(half) / angle : real(0.5);
  Quat out = Quat(Eigen::numext::cos(half), s * rotation.x(), s * rotation.y(), s * rotation.z()) * q;
  out.normalize();
  return out;
}

// The smallest eigenvalue of a symmetric matrix, by its characteristic polynomial.
PALP_HD inline real smallest_eigenvalue(const Mat3& H) {
  const real middle = H.trace() / real(3);
  const Mat3 B = H - middle * Mat3::Identity();
  const real spread = Eigen::numext::sqrt(B.squaredNorm() / real(6));
  if (!(spread > real(0))) return middle;
  const real r = B.determinant() / (real(2) * spread * spread * spread);
  const real angle = r > real(-1) ? (r < real(1) ? Eigen::numext::acos(r) : real(0)) : kPi;
  return middle + real(2) * spread * Eigen::numext::cos((angle + real(2) * kPi) / real(3));
}

// The proper rotation R nearest to A, that is with the largest tr(R^T A), from the guess q. Newton's method; where the
// Hessian tr(S) I - sym(S), S = R^T A, is not positive definite (A may be inverted or singular) it is shifted until it
// is. Where A leaves the rotation open, the guess decides. Of Newton steps on a warm start one or two suffice
// (Kugelstadt, Koschier & Bender 2018); the loop ends at convergence, because angular momentum depends on it.
PALP_HD inline Quat closest_rotation(Mat3 A, Quat q) {
  const real size = A.norm();
  if (!(size > real(0))) return q;
  A /= size;
  constexpr real kConverged = sizeof(real) == 4 ? real(1e-6) : real(1e-12);
  for (int round = 0; round < 60; ++round) {
    const Mat3 R = q.toRotationMatrix();
    const Mat3 S = R.transpose() * A;
    const Vec3 slope(S(2, 1) - S(1, 2), S(0, 2) - S(2, 0), S(1, 0) - S(0, 1));
    Mat3 H = S.trace() * Mat3::Identity() - real(0.5) * (S + S.transpose());
    const real minor = H(0, 0) * H(1, 1) - H(0, 1) * H(0, 1);
    bool saddle = false;
    if (!(H(0, 0) > real(0.01)) || !(minor > real(0.01) * H(0, 0)) || !(H.determinant() > real(0.01) * minor)) {
      const real least = smallest_eigenvalue(H);
      saddle = least < real(-0.01);
      if (least < real(0.05)) H += (real(0.05) - least) * Mat3::Identity();
    }
    Vec3 turn = H.inverse() * slope;
    // on a saddle, such as half a turn away, the slope vanishes, too
    if (saddle && !(slope.norm() > real(1e-4))) turn = Vec3(real(0.3), real(0.2), real(0.1));
    const real angle = turn.norm();
    if (angle > real(0.5)) turn *= real(0.5) / angle;
    q = rotated(q, R * turn);
    if (!(angle > kConverged)) break;
  }
  return q;
}

}  // namespace palp
