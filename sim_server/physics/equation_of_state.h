// The equation of state of weakly compressible fluids, linear about the rest density (Mueller et al. 2003, Eq. 12):
//
// p = c^2 (rho - rho0)
//
// symbol  meaning                          unit
// p       pressure, zero at rest density   Pa
// rho     density                          kg/m^3
// rho0    rest density                     kg/m^3
// c       speed of sound of the model      m/s
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

template <class S>
PALP_HD S pressure_at(S rho, S rho0, S c) {
  return c * c * (rho - rho0);
}

template <class S>
PALP_HD S density_at(S p, S rho0, S c) {
  return rho0 + p / (c * c);
}

// Returns rho / rho0 - 1 at this pressure.
template <class S>
PALP_HD S compression_at(S p, S rho0, S c) {
  return p / (c * c * rho0);
}

// Returns the pressure per compression [Pa].
template <class S>
PALP_HD S bulk_modulus(S rho0, S c) {
  return rho0 * c * c;
}

}  // namespace palp
