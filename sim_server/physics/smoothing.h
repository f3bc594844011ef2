// Smoothing kernels (paper Eq. 1). All have the support radius H: W(r >= H) = 0.
//
// The gradient is used as gradW(x_ij) = -F(r) x_ij with F = -W'(r) / r >= 0, so that no unit vector, and no division by
// the distance, is needed where the kernel is smooth at the origin. The scalar is a template parameter: kernels of the
// simulation use real, host code that plans or measures uses double.
#pragma once

#include <cstdint>

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
  template <class T>
  PALP_HD T W(T r) const {
    const T q = r * inv_support, u = positive(T(S(1) - q)), u2 = u * u;
    return w_scale * u2 * u2 * (S(4) * q + S(1));
  }
  template <class T>
  PALP_HD T F(T r) const {
    const T u = positive(T(S(1) - r * inv_support));
    return f_scale * u * u * u;
  }
  // The integrals that walls take (wall_share.h); polynomials in u.
  PALP_HD S over_plane(S z) const {
    const S u = positive(S(1) - z * inv_support), u2 = u * u;
    return S(3) * inv_support * u2 * u2 * u * (S(7) + u * (S(-10.5) + S(4) * u));
  }
  PALP_HD S second_tail(S d) const {
    const S u = positive(S(1) - d * inv_support), u3 = u * u * u;
    return support * u3 * u3 * u * (S(0.5) + u * (S(-9) / 16 + u / 6));
  }
  PALP_HD S fourth_tail(S d) const {
    const S u = positive(S(1) - d * inv_support), u3 = u * u * u;
    return support * support * support * u3 * u3 * u *
           (S(1) + u * (S(-2.75) + u * (S(2.875) + u * (S(-65) / 48 + S(8) / 33 * u))));
  }
};
using WendlandC2 = WendlandC2Of<real>;

// The quintic B-spline (Morris 1996), q = r/H, where what is below 0 counts as 0:
//   W = 2187/(40 pi H^3) ((1-q)^5 - 6 (2/3-q)^5 + 15 (1/3-q)^5)
// Its transform vanishes, flatly, at the wave number 6 pi / H, which with H = 3 dx is that of a lattice of particles.
template <class S>
struct QuinticSplineOf {
  S support;      // H [m]
  S inv_support;  // 1/H
  S w_scale;      // 2187/(40 pi H^3)
  S f_scale;      // 5 w_scale / H^2
  static QuinticSplineOf with_support(S H) {
    const S w = S(2187) / (S(40) * kPiOf<S> * H * H * H);
    return {H, S(1) / H, w, S(5) * w / (H * H)};
  }
  template <class T>
  PALP_HD T W(T r) const {
    return w_scale * of_knots<5>(T(r * inv_support));
  }
  template <class T>
  PALP_HD T F(T r) const {
    const T q = r * inv_support, least = S(3e-4);  // nearer the digits of the slope are lost
    return f_scale * of_knots<4>(q) / select(q > least, q, least);
  }
  // The integrals that walls take (wall_share.h).
  PALP_HD S over_plane(S z) const {
    const S q = z * inv_support;
    return S(2) * kPiOf<S> * w_scale * support * support * (q * tail<1>(q) + tail<2>(q));
  }
  PALP_HD S second_tail(S d) const {
    const S q = d * inv_support, H2 = support * support;
    return S(2) * kPiOf<S> * w_scale * H2 * H2 * (q * tail<3>(q) + S(3) * tail<4>(q));
  }
  PALP_HD S fourth_tail(S d) const {
    const S q = d * inv_support, H2 = support * support;
    return S(4) * kPiOf<S> * w_scale * H2 * H2 * H2 *
           (q * (q * (q * tail<3>(q) + S(6) * tail<4>(q)) + S(15) * tail<5>(q)) + S(15) * tail<6>(q));
  }

 private:
  template <int kPower, class T>
  PALP_HD static T power(T x) {
    if constexpr (kPower == 1) {
      return x;
    } else {
      const T half = power<kPower / 2>(x), square = half * half;
      return kPower % 2 == 0 ? square : x * square;
    }
  }
  template <int kPower, class T>
  PALP_HD static T of_knots(T q) {
    const T outer = positive(T(S(1) - q)), middle = positive(T(S(2) / S(3) - q)), inner = positive(T(S(1) / S(3) - q));
    return power<kPower>(outer) - S(6) * power<kPower>(middle) + S(15) * power<kPower>(inner);
  }
  // Returns 5! / (5 + times)!.
  static constexpr S scale(int times) { return times == 0 ? S(1) : scale(times - 1) / S(5 + times); }
  // Returns W / w_scale, integrated kTimes times over q from q to 1.
  template <int kTimes>
  PALP_HD static S tail(S q) {
    constexpr S kScale = scale(kTimes);
    return kScale * of_knots<5 + kTimes>(q);
  }
};
using QuinticSpline = QuinticSplineOf<real>;

// The support radius in spacings from which on fluids have the quintic spline. Particles in their places bear shear
// under pressure, which the spline takes away (tools/results/felt_remaining.md: a wave's period, a ball's drag). With
// fewer neighbours no kernel does: of Wendland's, places are stiff and what rests is still, where splines creep.
inline constexpr double kQuinticFrom = 2.5;
enum class KernelType : std::uint8_t { wendland, quintic };
constexpr KernelType fluid_kernel_type(double support_over_spacing) {
  return support_over_spacing >= kQuinticFrom ? KernelType::quintic : KernelType::wendland;
}

// The kernel of fluids, of all that acts on them, and of heat.
template <class S>
struct FluidKernelOf {
  S support;  // H [m]
  bool quintic;
  WendlandC2Of<S> wendland;
  QuinticSplineOf<S> spline;
  static FluidKernelOf with_support(S H, S spacing) {
    return {H, fluid_kernel_type(double(H) / double(spacing)) == KernelType::quintic, WendlandC2Of<S>::with_support(H),
            QuinticSplineOf<S>::with_support(H)};
  }
  PALP_HD S W(S r) const { return quintic ? spline.W(r) : wendland.W(r); }
  PALP_HD S F(S r) const { return quintic ? spline.F(r) : wendland.F(r); }
  // Returns 2 pi int_z^H W r dr: the kernel over a plane at the distance z >= 0 [1/m].
  PALP_HD S over_plane(S z) const { return quintic ? spline.over_plane(z) : wendland.over_plane(z); }
  // Returns pi int_d^H W r (r - d)^2 dr [m].
  PALP_HD S second_tail(S d) const { return quintic ? spline.second_tail(d) : wendland.second_tail(d); }
  // Returns pi/2 int_d^H W r (r^2 - d^2)^2 dr [m^3].
  PALP_HD S fourth_tail(S d) const { return quintic ? spline.fourth_tail(d) : wendland.fourth_tail(d); }
};
using FluidKernel = FluidKernelOf<real>;

// Calls f with the kernel that fluids have, of its own type: what asks for it in each pair is made for either one.
template <class F>
void with_type(const FluidKernel& kernel, F&& f) {
  if (kernel.quintic)
    f(kernel.spline);
  else
    f(kernel.wendland);
}

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
