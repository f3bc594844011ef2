// Scenes whose numbers no plan can serve. Host only.
#pragma once

#include "sim_server/solver/plan.h"

namespace palp {

// Throws a ConfigError for a scene so far from the origin that places could not be told apart well enough.
void check_places(const Scene& scene);

// Throws a ConfigError where rounding of places is too large a part of how far things move in a sub-step: a small one
// for what is held together by contact or bonds, half for fluids. Elastic bodies know how far they are from their place
// at rest.
void check_motion(const Scene& scene, const Plan& plan);

// Throws a ConfigError for explicit elasticity in so short sub-steps that their rounding moves bodies.
void check_stiffness(const Scene& scene, const Plan& plan);

// Throws a ConfigError for solids that change state or hold on to others and that method "paper" could not bear: its
// forces are the gradient of no energy, so that a solid which its weight crushes bounces ever higher.
void check_weight(const Scene& scene, const Plan& plan);

// Throws a ConfigError for elastic bodies of method "paper" that need damping and have too little. The factor I + G of
// Eq. 4, and a rotation that is taken from other weights than the gradient, leave the forces without an energy, so that
// bodies swing ever further at any sub-step. That was seen of bodies that begin to spin or to deform with a Poisson's
// ratio below 0 or above 0.45, and of soft ones that hold on to others; three hundredths of critical damping ended it.
void check_damping(const Scene& scene, const Plan& plan);

// Throws a ConfigError for media that meet by method "paper" and differ in density more than it can bear: its pressure
// weighs neighbours by their mass, so that a light one is thrown by a heavy one. A solid is hit from one side alone and
// may be heavier: fluids 200 times lighter than a tray were bounded under a hundredfold gravity, one 700 times lighter
// was not.
void check_densities(const Scene& scene, const Plan& plan);

}  // namespace palp
