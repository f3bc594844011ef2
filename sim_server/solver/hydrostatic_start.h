// The pressures that fluids start with. Host only.
#pragma once

#include <vector>

#include "sim_server/solver/plan.h"

namespace palp {

// Returns the pressure of each particle at the start [Pa], in the scene's order: of fluids as if they had always been
// there, under their own weight and that of the fluids on them. Without it a fluid would drop by its compression and
// ring for seconds. Zero for solids, with method "paper", and where gravity grows from zero.
std::vector<double> hydrostatic_start(const Scene& scene, const Plan& plan);

}  // namespace palp
