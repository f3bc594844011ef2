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

// A B-spline of order 4 or 5 (Morris 1996), q = r/H, where what is below 0 counts as 0:
//   W = w sum_j c_j (k_j - q)^n, knots k_j = 1 - 2 j / (n + 1), j = 0 to 2, c_j = 1, -(n + 1), (n + 1) n / 2
// Its transform vanishes, flatly, at the wave number (n + 1) pi / H, which with H = (n + 1)/2 dx is that of a lattice
// of particles.
template <class S, int kOrder>
struct SplineOf {
  static_assert(kOrder == 4 || kOrder == 5);
  S support;      // H [m]
  S inv_support;  // 1/H
  S w_scale;      // w
  S f_scale;      // n w / H^2
  static SplineOf with_support(S H) {
    const S w = (kOrder == 4 ? S(78125) / S(2560) : S(2187) / S(40)) / (kPiOf<S> * H * H * H);
    return {H, S(1) / H, w, S(kOrder) * w / (H * H)};
  }
  template <class T>
  PALP_HD T W(T r) const {
    return w_scale * of_knots<kOrder>(T(r * inv_support));
  }
  template <class T>
  PALP_HD T F(T r) const {
    const T q = r * inv_support, least = S(3e-4);  // nearer the digits of the slope are lost
    return f_scale * of_knots<kOrder - 1>(q) / select(q > least, q, least);
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
    constexpr S n = kOrder, kMiddle = S(1) - S(2) / (n + S(1)), kInner = S(1) - S(4) / (n + S(1));
    const T outer = positive(T(S(1) - q)), middle = positive(T(kMiddle - q)), inner = positive(T(kInner - q));
    return power<kPower>(outer) - (n + S(1)) * power<kPower>(middle) + (n + S(1)) * n / S(2) * power<kPower>(inner);
  }
  // Returns n! / (n + times)!.
  static constexpr S scale(int times) { return times == 0 ? S(1) : scale(times - 1) / S(kOrder + times); }
  // Returns W / w_scale, integrated kTimes times over q from q to 1.
  template <int kTimes>
  PALP_HD static S tail(S q) {
    constexpr S kScale = scale(kTimes);
    return kScale * of_knots<kOrder + kTimes>(q);
  }
};
template <class S>
using QuarticSplineOf = SplineOf<S, 4>;
template <class S>
using QuinticSplineOf = SplineOf<S, 5>;

// The support radii in spacings from which on fluids have the quartic and the quintic spline. Particles in their places
// bear shear under pressure, which a spline takes away about the support radius of its own, but for a hundredth of the
// pressure (tools/lattice_stiffness.py). With fewer neighbours no kernel does: of Wendland's, places are stiff and what
// rests is still, where splines creep or boil.
inline constexpr double kQuarticFrom = 2.5, kQuinticFrom = 2.78;
enum class KernelType : std::uint8_t { wendland, quartic, quintic };
constexpr KernelType fluid_kernel_type(double support_over_spacing) {
  if (support_over_spacing < kQuarticFrom) return KernelType::wendland;
  return support_over_spacing < kQuinticFrom ? KernelType::quartic : KernelType::quintic;
}

// The kernel of fluids, of all that acts on them, and of heat.
template <class S>
struct FluidKernelOf {
  S support;  // H [m]
  KernelType type;
  WendlandC2Of<S> wendland;
  QuarticSplineOf<S> quartic;
  QuinticSplineOf<S> quintic;
  static FluidKernelOf with_support(S H, S spacing) {
    return {H, fluid_kernel_type(double(H) / double(spacing)), WendlandC2Of<S>::with_support(H),
            QuarticSplineOf<S>::with_support(H), QuinticSplineOf<S>::with_support(H)};
  }
  PALP_HD S W(S r) const {
    return of_type([r](const auto& kernel) { return kernel.W(r); });
  }
  PALP_HD S F(S r) const {
    return of_type([r](const auto& kernel) { return kernel.F(r); });
  }
  // Returns 2 pi int_z^H W r dr: the kernel over a plane at the distance z >= 0 [1/m].
  PALP_HD S over_plane(S z) const {
    return of_type([z](const auto& kernel) { return kernel.over_plane(z); });
  }
  // Returns pi int_d^H W r (r - d)^2 dr [m].
  PALP_HD S second_tail(S d) const {
    return of_type([d](const auto& kernel) { return kernel.second_tail(d); });
  }
  // Returns pi/2 int_d^H W r (r^2 - d^2)^2 dr [m^3].
  PALP_HD S fourth_tail(S d) const {
    return of_type([d](const auto& kernel) { return kernel.fourth_tail(d); });
  }

 private:
  template <class F>
  PALP_HD S of_type(F&& f) const {
    if (type == KernelType::wendland) return f(wendland);
    return type == KernelType::quartic ? f(quartic) : f(quintic);
  }
};
using FluidKernel = FluidKernelOf<real>;

// Calls f with the kernel that fluids have, of its own type: what asks for it in each pair is made for any one of them.
template <class F>
void with_type(const FluidKernel& kernel, F&& f) {
  if (kernel.type == KernelType::wendland)
    f(kernel.wendland);
  else if (kernel.type == KernelType::quartic)
    f(kernel.quartic);
  else
    f(kernel.quintic);
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
