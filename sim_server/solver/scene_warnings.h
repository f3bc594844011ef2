// A scene is judged here once it is planned: faults that no run could mend, and what may be meant but is mostly a
// mistake.
#pragma once

#include <string>
#include <vector>

#include "sim_server/solver/plan.h"

namespace palp {

// Returns one sentence for each doubt: where, what, what was expected, what to do. Throws ConfigError with every fault
// found: a body that is bonded to others of which none is within its reach.
std::vector<std::string> scene_warnings(const Scene& scene, const Plan& plan);

}  // namespace palp
