// Scenes whose numbers no plan can serve. Host only.
#pragma once

#include "sim_server/solver/plan.h"

namespace palp {

// Throws a ConfigError for a scene so far from the origin that places could not be told apart well enough.
void check_rounding(const Scene& scene);

// Throws a ConfigError for matter that changes state and that method "paper" could not bear: its pressure is the
// gradient of no energy, so that a solid which its weight crushes bounces ever higher.
void check_weight(const Scene& scene, const Plan& plan);

}  // namespace palp
