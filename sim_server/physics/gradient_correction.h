// The correction of kernel gradients (Bonet & Lok 1999): with L = (sum_j V_j F X X^T)^-1 a sum over neighbours gives
// affine fields their exact gradient.
#pragma once

#include "sim_server/physics/principal_axes.h"

namespace palp {

template <class S>
struct GradientCorrection {
  Mat3Of<S> inverse;     // L
  Mat3Of<S> projection;  // onto the directions that the neighbours span: I where they fill space
};

// The share of a moment's largest principal value below which a neighbourhood counts as flat along that axis.
inline constexpr double kFlatNeighborhood = 1e-3;

// Inverts a moment sum_j V_j F X X^T along those of its principal axes whose value is more than the share `flat` of the
// largest. Across the others neighbours span no space, and a gradient would be as stiff as they are flat.
template <class Derived>
PALP_HD inline GradientCorrection<typename Derived::Scalar> gradient_correction(
    const Eigen::MatrixBase<Derived>& moment, typename Derived::Scalar flat) {
  using S = typename Derived::Scalar;
  const PrincipalAxesOf<S> principal = principal_axes(moment);
  const S threshold = flat * principal.value.maxCoeff();
  GradientCorrection<S> c{Mat3Of<S>::Zero(), Mat3Of<S>::Zero()};
  for (int a = 0; a < 3; ++a) {
    if (!(principal.value[a] > threshold)) continue;
    const Vec3Of<S> n = principal.axis.col(a);
    const Mat3Of<S> along = n * n.transpose();
    c.inverse += along / principal.value[a];
    c.projection += along;
  }
  return c;
}

}  // namespace palp
