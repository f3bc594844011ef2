// The stress by which a push on the face of an elastic particle acts on the matter around it.
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

// The volume, over that at rest, below which matter has no face that could be found.
inline constexpr real kFlatCell = real(0.05);

// The viscosity of matter whose face is pressed, over that of waves, spacing sqrt(mu density). A push and the stress
// that it adds come from no common energy: matter that is squeezed under one push and swells under another gains what
// neither gives, and did where a hand holds it nearly flat, up to five times what the stability map allows. Of 192
// blocks (tools/results/felt_remaining.md) 48 were faults without it, 17 with 0.1, 9 with 0.2 and 5 with 0.4, from 0.2
// on all under tools of 10 mg. What is pressed and rests has none of it.
inline constexpr real kPressedViscosity = real(0.2);

// Returns det(F) F^-T.
PALP_HD inline Mat3 cofactors(const Mat3& F) {
  Mat3 c;
  c.col(0) = F.col(1).cross(F.col(2));
  c.col(1) = F.col(2).cross(F.col(0));
  c.col(2) = F.col(0).cross(F.col(1));
  return c;
}

// Returns a place from a particle's middle [m], brought nearer until it is no farther from there at rest.
PALP_HD inline Vec3 within_cell(const Mat3& F, const Vec3& at) {
  const Mat3 c = cofactors(F);
  const real volume = F.col(0).dot(c.col(0)), now = at.norm();
  if (!(volume > kFlatCell)) return Vec3(0, 0, 0);
  const real at_rest = (c.transpose() * at).norm() / volume;
  return (at_rest > now ? now / at_rest : real(1)) * at;
}

// Returns what contact adds to the stress P [Pa]. A push f at x_f from a particle's middle, on its cell's face, does
// the work f.(dx + dF X_f), so that it is f on the middle and a stress -f X_f^T / V. Without that the first layer of a
// body that is pressed bears half of the pressure, and the one below too much: in matter that is nearly incompressible
// the rest is missing where it flows aside, and a ball on a layer of n spacings was felt harder by about 1 / 2n.
// pressed: -f x_f^T / V, of the last sub-step.
PALP_HD inline Mat3 contact_stress(const Mat3& pressed, const Mat3& F) {
  if (pressed.isZero(0)) return Mat3::Zero();
  const Mat3 c = cofactors(F);
  const real volume = F.col(0).dot(c.col(0));
  if (!(volume > kFlatCell)) return Mat3::Zero();
  return (real(1) / volume) * (pressed * c);
}

// Returns the stress (first Piola-Kirchhoff) [Pa] by which matter that is pressed resists the rate at which its strain
// changes: F S, S = kPressedViscosity spacing sqrt(mu density) (F^T F - F_0^T F_0) / 2 dt. It takes work from whatever
// strain there is, and none from a turn. What is stretched would have the fourth power of its stretch as a viscosity,
// which no sub-step is chosen for, and is spared that.
// before: F_0, of the sub-step before; mu, density: Lame's second constant [Pa] and density at rest [kg/m^3].
PALP_HD inline Mat3 contact_damping(const Mat3& before, const Mat3& F, real mu, real density, real spacing, real dt) {
  const real viscosity = kPressedViscosity * spacing * Eigen::numext::sqrt(mu * density);
  const Mat3 half = (F - before).transpose() * (F + before);  // with its transpose twice the change, and no digits lost
  const real grown = F.squaredNorm() - real(2), large = grown > real(1) ? grown : real(1);
  return (real(0.25) * viscosity / (dt * large * large)) * (F * (half + half.transpose()));
}

// Returns the work per volume that contact's stress has done on a particle's strain, as if the push of now had been
// there before the strain, with the opposite sign [J/m^3]. Where both grew together it has done half of that, but in a
// bounce half is too little. It gets the work back as it goes. The spring of contact is stiffer than half a cell
// (kContactLayers) and holds less than that, so that both together may hold less than none.
PALP_HD inline real contact_energy(const Mat3& pressed, const Mat3& F, const Mat3& R) {
  return contact_stress(pressed, F).cwiseProduct(F - R).sum();
}

// Returns the couple with which contact's stress turns a particle's neighbourhood, x_f cross f [N m].
PALP_HD inline Vec3 contact_couple(const Mat3& pressed, real volume) {
  return volume * Vec3(pressed(1, 2) - pressed(2, 1), pressed(2, 0) - pressed(0, 2), pressed(0, 1) - pressed(1, 0));
}

}  // namespace palp
