// Principal values and axes of symmetric matrices.
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

template <class S>
struct PrincipalAxesOf {
  Vec3Of<S> value;  // in no order
  Mat3Of<S> axis;   // unit columns
};
using PrincipalAxes = PrincipalAxesOf<real>;

// Rotates A so that A(p, q) vanishes, and the axes with it.
template <int p, int q, class S>
PALP_HD inline void jacobi_rotation(PrincipalAxesOf<S>& out, Mat3Of<S>& A) {
  const S apq = A(p, q);
  if (apq == S(0)) return;
  constexpr int r = 3 - p - q;
  const S theta = (A(q, q) - A(p, p)) / (S(2) * apq);
  const S root = Eigen::numext::abs(theta) + Eigen::numext::sqrt(theta * theta + S(1));
  const S t = theta < S(0) ? S(-1) / root : S(1) / root;
  const S c = S(1) / Eigen::numext::sqrt(t * t + S(1)), s = t * c;
  A(p, p) -= t * apq;
  A(q, q) += t * apq;
  A(p, q) = A(q, p) = 0;
  const S arp = A(r, p), arq = A(r, q);
  A(r, p) = A(p, r) = c * arp - s * arq;
  A(r, q) = A(q, r) = s * arp + c * arq;
  const Vec3Of<S> vp = out.axis.col(p), vq = out.axis.col(q);
  out.axis.col(p) = c * vp - s * vq;
  out.axis.col(q) = s * vp + c * vq;
}

// Returns the principal axes of a symmetric matrix, by cyclic Jacobi rotations: a few sweeps, no branches on which
// values are alike, and axes that are orthogonal to round-off whatever A is (Golub & Van Loan, Matrix
// Computations, 8.5).
template <class Derived>
PALP_HD inline PrincipalAxesOf<typename Derived::Scalar> principal_axes(const Eigen::MatrixBase<Derived>& matrix) {
  using S = typename Derived::Scalar;
  Mat3Of<S> A = matrix;
  PrincipalAxesOf<S> out;
  out.axis.setIdentity();
  constexpr S kSmall = sizeof(S) == 4 ? S(1e-8) : S(1e-16);
  for (int sweep = 0; sweep < 10; ++sweep) {
    const S off = A(0, 1) * A(0, 1) + A(0, 2) * A(0, 2) + A(1, 2) * A(1, 2);
    if (!(off > kSmall * kSmall * A.squaredNorm())) break;
    jacobi_rotation<0, 1>(out, A);
    jacobi_rotation<0, 2>(out, A);
    jacobi_rotation<1, 2>(out, A);
  }
  out.value = A.diagonal();
  return out;
}

// Returns the axis at rest along which F stretches most, and that stretch; zero where it is less than the threshold.
PALP_HD inline Packed greatest_stretch(const Mat3& F, real threshold) {
  const Mat3 C = F.transpose() * F;
  const real square = threshold * threshold;
  if (!(C.squaredNorm() > square * square)) return pack(Vec3(0, 0, 0), 0);
  const PrincipalAxes principal = principal_axes(C);
  // no index is a variable: a GPU's compiler would keep all axes in memory
  real most = principal.value[0];
  Vec3 axis = principal.axis.col(0);
  for (int a = 1; a < 3; ++a) {
    if (!(principal.value[a] > most)) continue;
    most = principal.value[a];
    axis = principal.axis.col(a);
  }
  if (!(most > square)) return pack(Vec3(0, 0, 0), 0);
  return pack(axis, Eigen::numext::sqrt(most));
}

}  // namespace palp
