// Smoothing kernels (paper Eq. 1). All have the support radius H: W(r >= H) = 0.
//
// The gradient is used as gradW(x_ij) = -F(r) x_ij with F = -W'(r) / r >= 0, so that no unit vector, and no division by
// the distance, is needed where the kernel is smooth at the origin. The scalar is a template parameter: kernels of the
// simulation use real, host code that plans or measures uses double.
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

// Wendland C2 in three dimensions (Wendland 1995; SPH: Dehnen & Aly 2012): W = 21/(2 pi H^3) (1-q)^4 (4q+1), q = r/H.
template <class S>
struct WendlandC2Of {
  S support;      // H [m]
  S inv_support;  // 1/H
  S w_scale;      // 21/(2 pi H^3)
  S f_scale;      // 20 w_scale / H^2
  static WendlandC2Of with_support(S H) {
    const S w = S(21) / (S(2) * kPiOf<S> * H * H * H);
    return {H, S(1) / H, w, S(20) * w / (H * H)};
  }
  // Returns the kernel over its value at 0, with H = 1.
  static constexpr WendlandC2Of unit() { return {S(1), S(1), S(1), S(20)}; }
  PALP_HD S W(S r) const {
    const S q = r * inv_support, u = within(q), u2 = u * u;
    return w_scale * u2 * u2 * (S(4) * q + S(1));
  }
  PALP_HD S F(S r) const {
    const S u = within(r * inv_support);
    return f_scale * u * u * u;
  }

 private:
  // Returns 1 - q within the support, 0 past it.
  PALP_HD static S within(S q) {
    const S u = S(1) - q;
    return u > S(0) ? u : S(0);
  }
};
using WendlandC2 = WendlandC2Of<real>;

// Two kernels of Mueller, Charypar & Gross 2003, which the paper's equations are used with. Their third one, "spiky",
// whose gradient they take for pressure, is left out: density and pressure have one kernel (paper.h says why).
template <class S>
struct MuellerOf {
  S support;
  S poly6_scale;      // 315/(64 pi H^9)
  S laplacian_scale;  // 45/(pi H^6)
  static MuellerOf with_support(S H) {
    const S H2 = H * H, H6 = H2 * H2 * H2;
    return {H, S(315) / (S(64) * kPiOf<S> * H6 * H2 * H), S(45) / (kPiOf<S> * H6)};
  }
  PALP_HD S poly6(S r2) const {
    const S u = support * support - r2;
    return u > S(0) ? poly6_scale * u * u * u : S(0);
  }
  PALP_HD S poly6_F(S r2) const {
    const S u = support * support - r2;
    return u > S(0) ? S(6) * poly6_scale * u * u : S(0);
  }
  // Returns the Laplacian of the viscosity kernel, which is positive everywhere, so that viscosity only ever takes
  // energy.
  PALP_HD S laplacian(S r) const {
    const S u = support - r;
    return u > S(0) ? laplacian_scale * u : S(0);
  }
};
using Mueller = MuellerOf<real>;

}  // namespace palp
