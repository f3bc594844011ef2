// Which scenes shift particles (physics/shift.h), and how often they look at what is around them.
#pragma once

#include "sim_server/solver/plan.h"

namespace palp {

// Plans particle shifting, last of all. Throws ConfigError where numerics.shift asks for it in a scene that cannot have
// it.
void plan_shift(const Scene& scene, Plan& plan);

}  // namespace palp
