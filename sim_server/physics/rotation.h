// Rotations of rigid bodies and of neighbourhoods.
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

// Returns q turned by a rotation vector in world axes [rad].
PALP_HD inline Quat rotated(const Quat& q, const Vec3& rotation) {
  const real angle = rotation.norm();
  const real half = real(0.5) * angle;
  const real s = angle > real(1e-6) ? Eigen::numext::sin(half) / angle : real(0.5);
  Quat out = Quat(Eigen::numext::cos(half), s * rotation.x(), s * rotation.y(), s * rotation.z()) * q;
  out.normalize();
  return out;
}

// Returns the smallest eigenvalue of a symmetric matrix, by its characteristic polynomial.
PALP_HD inline real smallest_eigenvalue(const Mat3& H) {
  const real middle = H.trace() / real(3);
  const Mat3 B = H - middle * Mat3::Identity();
  const real spread = Eigen::numext::sqrt(B.squaredNorm() / real(6));
  if (!(spread > real(0))) return middle;
  const real r = B.determinant() / (real(2) * spread * spread * spread);
  const real angle = r > real(-1) ? (r < real(1) ? Eigen::numext::acos(r) : real(0)) : kPi;
  return middle + real(2) * spread * Eigen::numext::cos((angle + real(2) * kPi) / real(3));
}

// Returns the proper rotation R nearest to A, that is with the largest tr(R^T A), from the guess q. Newton's method;
// where the
// Hessian tr(S) I - sym(S), S = R^T A, is not positive definite (A may be inverted or singular) it is shifted until it
// is. Where A leaves the rotation open, the guess decides. Of Newton steps on a warm start one or two suffice
// (Kugelstadt, Koschier & Bender 2018); the loop ends at convergence, because angular momentum depends on it.
PALP_HD inline Quat closest_rotation(Mat3 A, Quat q) {
  const real size = A.norm();
  if (!(size > real(0))) return q;
  A /= size;
  constexpr real kConverged = sizeof(real) == 4 ? real(1e-6) : real(1e-12);  // [rad]
  constexpr real kFlat = real(0.1) * kConverged;
  for (int round = 0; round < 60; ++round) {
    const Mat3 R = q.toRotationMatrix();
    const Mat3 S = R.transpose() * A;
    const Vec3 slope(S(2, 1) - S(1, 2), S(0, 2) - S(2, 0), S(1, 0) - S(0, 1));
    // the symmetric Hessian: diagonal a b c, off-diagonal d = 01, e = 02, f = 12
    real a = S(1, 1) + S(2, 2), b = S(0, 0) + S(2, 2), c = S(0, 0) + S(1, 1);
    const real d = real(-0.5) * (S(0, 1) + S(1, 0)), e = real(-0.5) * (S(0, 2) + S(2, 0)),
               f = real(-0.5) * (S(1, 2) + S(2, 1));
    const auto determinant = [&] { return a * (b * c - f * f) - d * (d * c - e * f) + e * (d * f - b * e); };
    const real minor = a * b - d * d;
    bool saddle = false;
    if (!(a > real(0.01)) || !(minor > real(0.01) * a) || !(determinant() > real(0.01) * minor)) {
      Mat3 H;
      H << a, d, e, d, b, f, e, f, c;
      const real smallest = smallest_eigenvalue(H), shift = smallest < real(0.05) ? real(0.05) - smallest : real(0);
      saddle = smallest < real(-0.01);
      a += shift;
      b += shift;
      c += shift;
    } else if (slope.squaredNorm() < kFlat * kFlat) {
      break;
    }
    const real inverse = real(1) / determinant();
    const real A01 = e * f - d * c, A02 = d * f - b * e, A12 = d * e - a * f;  // entries of the adjugate
    Vec3 turn = inverse * Vec3((b * c - f * f) * slope.x() + A01 * slope.y() + A02 * slope.z(),
                               A01 * slope.x() + (a * c - e * e) * slope.y() + A12 * slope.z(),
                               A02 * slope.x() + A12 * slope.y() + (a * b - d * d) * slope.z());
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
