// Plasticity at finite strain: a dent stays. One particle's law, with its state; von Mises's yield, isotropic
// hardening.
//
// symbol      meaning                                                        source
// F = Fe Fp   elastic and plastic part, det Fp = 1                           Lee 1969
// Fe = R S    S = sum_a s_a n_a n_a^T, e_a = log s_a                         Hencky's strain
// psi         mu sum e_a^2 + lambda/2 (sum e_a)^2, tau_a = d psi/d e_a       Weber & Anand 1990, Eterovic & Bathe 1990
// P           R (sum_a tau_a / s_a n_a n_a^T) Fp^-T = d psi/d F
// yield       |dev tau| <= sqrt(2/3) (s_y + H a), a: accumulated plastic strain
// return      de = (|dev tau| - sqrt(2/3) (s_y + H a)) / (2 mu + 2/3 H) along n = dev e / |dev e|:
//             Fp^-1 <- Fp^-1 sum_a exp(-de n_a) n_a n_a^T, a <- a + sqrt(2/3) de      Simo 1992
//
// In logarithms the return is that of small strains, exactly radial and exactly without change of volume, and it only
// ever takes energy. The stress is that of a body at rest in Fe: at small strains the same as of a material that does
// not yield. That one's own law (elastic.h) is not used: compressed by a few percent at nu near 1/2, its deviator turns
// against the strain, and a return along it would make energy.
#pragma once

#include "sim_server/physics/particles.h"
#include "sim_server/physics/principal_axes.h"
#include "sim_server/physics/rotation.h"

namespace palp {

// The elastic stretch below which the logarithm goes on as its tangent, so that inverted particles have a finite way
// back. Matter that is compressed that far does not flow.
inline constexpr real kMinStretch = real(0.5);
// The factor by which some direction gets shorter until a particle no longer flows: time steps are chosen for lengths
// at rest (elastic_plan.cpp).
inline constexpr real kMaxFlow = real(3);

// Returns log s of an elastic stretch s, given as s - 1.
PALP_HD inline real log_stretch(real s_minus_one) {
  const real s = real(1) + s_minus_one;
  if (s > kMinStretch) return Eigen::numext::log1p(s_minus_one);
  return Eigen::numext::log(real(kMinStretch)) + (s - kMinStretch) / kMinStretch;
}

// Returns the elastic energy per volume at rest [J/m^3].
PALP_HD inline real plastic_energy(const Material& m, const Mat3& Fe, const Mat3& R) {
  const Mat3 S = R.transpose() * Fe;
  const Vec3 strain = principal_axes(real(0.5) * (S + S.transpose()) - Mat3::Identity()).value;
  Vec3 e;
  for (int a = 0; a < 3; ++a) e[a] = log_stretch(strain[a]);
  return m.shear * e.squaredNorm() + real(0.5) * m.lame * e.sum() * e.sum();
}

// Returns the stress P at F. Advances the inverse of Fp and the accumulated plastic strain; q is R's guess and becomes
// R.
PALP_HD inline Mat3 plastic_stress(const Material& m, const Mat3& F, Quat& q, Mat3& inverse, real& hardened) {
  const Mat3 Fe = F * inverse;
  q = closest_rotation(Fe, q);
  const Mat3 R = q.toRotationMatrix(), S = R.transpose() * Fe;
  const PrincipalAxes principal = principal_axes(real(0.5) * (S + S.transpose()) - Mat3::Identity());
  const Mat3& n = principal.axis;
  Vec3 s = principal.value + Vec3::Ones(), e;
  for (int a = 0; a < 3; ++a) e[a] = log_stretch(principal.value[a]);
  const real volume = e.sum();
  const Vec3 deviator = e - Vec3::Constant(volume / real(3));
  const real size = deviator.norm();
  const real over =
      real(2) * m.shear * size - Eigen::numext::sqrt(real(2) / real(3)) * (m.yield + m.hardening * hardened);
  if (over > real(0) && s.minCoeff() > kMinStretch) {
    const real flow = over / (real(2) * m.shear + real(2) / real(3) * m.hardening);
    const Vec3 direction = deviator / size;
    Vec3 back;
    for (int a = 0; a < 3; ++a) back[a] = Eigen::numext::exp(-flow * direction[a]);
    Mat3 next = inverse * (n * back.asDiagonal() * n.transpose());
    next *= real(1) + (real(1) - next.determinant()) / real(3);  // rounding must not add up to a volume
    if (next.squaredNorm() < kMaxFlow * kMaxFlow) {
      inverse = next;
      hardened += Eigen::numext::sqrt(real(2) / real(3)) * flow;
      e -= flow * direction;
      s = s.cwiseProduct(back);
    }
  }
  Vec3 stress;
  for (int a = 0; a < 3; ++a)
    stress[a] = (real(2) * m.shear * e[a] + m.lame * volume) / (s[a] > kMinStretch ? s[a] : real(kMinStretch));
  return R * (n * stress.asDiagonal() * n.transpose()) * inverse.transpose();
}

}  // namespace palp
