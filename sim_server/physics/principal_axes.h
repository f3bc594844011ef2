// Principal values and axes of symmetric matrices.
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

struct PrincipalAxes {
  Vec3 value;  // in no order
  Mat3 axis;   // unit columns
};

// Turns A so that A(p, q) vanishes.
template <int p, int q>
PALP_HD inline void turn_away(PrincipalAxes& out, Mat3& A) {
  const real apq = A(p, q);
  if (apq == real(0)) return;
  constexpr int r = 3 - p - q;
  const real theta = (A(q, q) - A(p, p)) / (real(2) * apq);
  const real root = Eigen::numext::abs(theta) + Eigen::numext::sqrt(theta * theta + real(1));
  const real t = theta < real(0) ? real(-1) / root : real(1) / root;
  const real c = real(1) / Eigen::numext::sqrt(t * t + real(1)), s = t * c;
  A(p, p) -= t * apq;
  A(q, q) += t * apq;
  A(p, q) = A(q, p) = 0;
  const real arp = A(r, p), arq = A(r, q);
  A(r, p) = A(p, r) = c * arp - s * arq;
  A(r, q) = A(q, r) = s * arp + c * arq;
  const Vec3 vp = out.axis.col(p), vq = out.axis.col(q);
  out.axis.col(p) = c * vp - s * vq;
  out.axis.col(q) = s * vp + c * vq;
}

// Cyclic Jacobi rotations: a few sweeps, no branches on which values are alike, and axes that are orthogonal to
// round-off whatever A is (Golub & Van Loan, Matrix Computations, 8.5).
PALP_HD inline PrincipalAxes principal_axes(Mat3 A) {
  PrincipalAxes out;
  out.axis.setIdentity();
  constexpr real kSmall = sizeof(real) == 4 ? real(1e-8) : real(1e-16);
  for (int sweep = 0; sweep < 10; ++sweep) {
    const real off = A(0, 1) * A(0, 1) + A(0, 2) * A(0, 2) + A(1, 2) * A(1, 2);
    if (!(off > kSmall * kSmall * A.squaredNorm())) break;
    turn_away<0, 1>(out, A);
    turn_away<0, 2>(out, A);
    turn_away<1, 2>(out, A);
  }
  out.value = A.diagonal();
  return out;
}

// The axis at rest along which F stretches most, and that stretch; zero where it is less than least.
PALP_HD inline Packed greatest_stretch(const Mat3& F, real least) {
  const Mat3 C = F.transpose() * F;
  const real square = least * least;
  if (!(C.squaredNorm() > square * square)) return pack(Vec3(0, 0, 0), 0);
  const PrincipalAxes principal = principal_axes(C);
  int most = 0;
  for (int a = 1; a < 3; ++a)
    if (principal.value[a] > principal.value[most]) most = a;
  if (!(principal.value[most] > square)) return pack(Vec3(0, 0, 0), 0);
  return pack(principal.axis.col(most), Eigen::numext::sqrt(principal.value[most]));
}

}  // namespace palp
