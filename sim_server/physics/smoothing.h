// Smoothing kernels (paper Eq. 1). All have the support radius H: W(r >= H) = 0.
//
// The gradient is used as gradW(x_ij) = -F(r) x_ij with F = -W'(r) / r >= 0, so that no unit vector, and no division by
// the distance, is needed where the kernel is smooth at the origin.
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

// Wendland C2 in three dimensions (Wendland 1995; SPH: Dehnen & Aly 2012): W = 21/(2 pi H^3) (1-q)^4 (4q+1), q = r/H.
struct WendlandC2 {
  real support;      // H [m]
  real inv_support;  // 1/H
  real w_scale;      // 21/(2 pi H^3)
  real f_scale;      // 20 w_scale / H^2
  static WendlandC2 with_support(real H) {
    const real w = real(21) / (real(2) * kPi * H * H * H);
    return {H, real(1) / H, w, real(20) * w / (H * H)};
  }
  PALP_HD real W(real r) const {
    const real q = r * inv_support, u = real(1) - q, u2 = u * u;
    return u > real(0) ? w_scale * u2 * u2 * (real(4) * q + real(1)) : real(0);
  }
  PALP_HD real F(real r) const {
    const real u = real(1) - r * inv_support;
    return u > real(0) ? f_scale * u * u * u : real(0);
  }
};

// The three kernels of Mueller, Charypar & Gross 2003, which the paper's equations 2 and 3 are used with.
struct Mueller {
  real support;
  real poly6_scale;  // 315/(64 pi H^9)
  real spiky_scale;  // 45/(pi H^6): gradient of 15/(pi H^6) (H-r)^3
  static Mueller with_support(real H) {
    const real H2 = H * H, H6 = H2 * H2 * H2;
    return {H, real(315) / (real(64) * kPi * H6 * H2 * H), real(45) / (kPi * H6)};
  }
  PALP_HD real poly6(real r2) const {
    const real u = support * support - r2;
    return u > real(0) ? poly6_scale * u * u * u : real(0);
  }
  // F of the spiky kernel. Its W' is finite at r = 0, so coincident particles get no direction: zero.
  PALP_HD real spiky_F(real r) const {
    const real u = support - r;
    return u > real(0) && r > real(0) ? spiky_scale * u * u / r : real(0);
  }
  // Laplacian of the viscosity kernel: positive everywhere, so that viscosity only ever takes energy.
  PALP_HD real laplacian(real r) const {
    const real u = support - r;
    return u > real(0) ? spiky_scale * u : real(0);
  }
};

}  // namespace palp
