// The plan of viscosity: whether it is applied in stages (physics/viscosity.h), and in how many.
#pragma once

#include <string>

#include "sim_server/solver/plan.h"

namespace palp {

// Sets plan.viscous_stages; plan.support must be set. without: the sub-step that is allowed without the fluids'
// viscosity; beside_stages: the one that is allowed where it is taken in stages; stable: the largest one that it is
// stable with by linear theory [s]. Throws ConfigError when no number of stages will do.
void plan_viscosity(const Scene& scene, double without, double beside_stages, double stable, Plan& plan);

// Returns ", viscosity explicit" or ", viscosity in 17 stages ..."; nothing without a fluid.
std::string describe_viscosity(const Plan& plan);

}  // namespace palp
