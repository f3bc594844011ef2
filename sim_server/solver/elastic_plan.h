// The plan of elasticity: the limit that it sets to sub-steps, and whether an implicit solve
// (physics/implicit_elastic.h) takes the place of short ones, and in how many rounds.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_server/solver/plan.h"

namespace palp {

// The square of the speed of all elastic matter below which a round of the solve has nothing to add [m^2/s^2].
inline constexpr double kMinSpeed2 = 1e-12;

// Returns how far the weight of a body of particles would compress what it is made of.
double strain_under_weight(const Scene& scene, const Body& body);

// Returns the limits of explicit elastic bodies, or (changing) of the bonds of those that change state, by linear
// theory: the least by waves and the least by damping, as far as the scene has them.
std::vector<StepLimit> limits_by_elasticity(const Scene& scene, const Plan& plan, bool changing);

// Sets plan.elastic_rounds, elastic_sub_steps and elastic_choice. explicit_limit: the largest stable sub-step of the
// elastic bodies by linear theory; plan.dt_allowed: what all else allows [s]. Throws ConfigError when the scene asks
// for an implicit solve that its bodies do not allow.
void plan_elastic_solver(const Scene& scene, double explicit_limit, Plan& plan);

// Returns ", elasticity explicit ..." or ", elasticity implicit in up to 40 rounds ..."; nothing without elastic
// bodies.
std::string describe_elastic_solver(const Plan& plan);

// Returns the elastic bodies that are bonded to nothing.
std::vector<std::uint32_t> free_elastic_bodies(const Scene& scene, const Plan& plan);

}  // namespace palp
