// The stress by which a push on the face of an elastic particle acts on the matter around it.
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

// Returns what contact adds to the stress P [Pa]. A push f at x_f from a particle's middle, on its cell's face, does
// the work f.(dx + dF X_f), so that it is f on the middle and a stress -f X_f^T / V. Without that the first layer of a
// body that is pressed bears half of the pressure, and the one below too much: in matter that is nearly incompressible
// the rest is missing where it flows aside, and a ball on a layer of n spacings was felt harder by about 1 / 2n.
// pressed: -f x_f^T / V, of the last sub-step.
PALP_HD inline Mat3 contact_stress(const Mat3& pressed, const Mat3& F) {
  constexpr real kFlat = real(0.05);  // of the volume at rest: matter that has less has no face that could be found
  if (pressed.isZero(0)) return Mat3::Zero();
  const Vec3 a = F.col(0), b = F.col(1), c = F.col(2);
  Mat3 cofactors;  // det(F) F^-T
  cofactors.col(0) = b.cross(c);
  cofactors.col(1) = c.cross(a);
  cofactors.col(2) = a.cross(b);
  const real volume = a.dot(b.cross(c));
  if (!(volume > kFlat)) return Mat3::Zero();
  return (real(1) / volume) * (pressed * cofactors);
}

// Returns the couple with which contact's stress turns a particle's neighbourhood, x_f cross f [N m].
PALP_HD inline Vec3 contact_couple(const Mat3& pressed, real volume) {
  return volume * Vec3(pressed(1, 2) - pressed(2, 1), pressed(2, 0) - pressed(0, 2), pressed(0, 1) - pressed(1, 0));
}

}  // namespace palp
