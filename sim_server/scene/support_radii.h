// The support radii that a scene's numerics and its level give. Host only.
#pragma once

#include "sim_server/scene/scene.h"

namespace palp {

// Returns true when a fluid of the scene has surface tension or clings to solids.
bool has_cohesion(const Scene& scene);

// Returns the support radius H of fluids, and with method "paper" of all pairs [m].
double fluid_support(const Scene& scene);

// Returns the support radius H of elastic bodies with method "accurate" [m].
double elastic_support(const Scene& scene);

}  // namespace palp
