// What limits the sub-steps of elastic bodies, and whether an implicit solve (physics/implicit_elastic.h) takes the
// place of short ones, and in how many rounds.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_server/solver/plan.h"

namespace palp {

// Below this speed of all elastic matter a round of the solve has nothing to add [m^2/s^2].
inline constexpr double kLeastSpeed2 = 1e-12;

// A largest stable sub-step by linear theory, and of what [s].
struct StepLimit {
  double dt = 1e30;
  std::string by;
};

// Of an elastic material, its own [Pa s]. Method "paper" adds 0.01 rho c dx, c = sqrt(E / rho), since its elasticity
// feeds motion: a neighbourhood's rotation is found with weights W and its strain with gradW, so that the forces are no
// energy's gradient, and at surfaces vibrations of a few spacings grow by up to 0.009 c / dx. In all clamped blocks
// that were tried this damping ended it, a third of it not in all (tools/papers_elasticity.py).
double elastic_damping(const Scene& scene, const Plan& plan, const MaterialConfig& m);

// Of explicit elastic bodies, or (changing) of the bonds of those that change state.
StepLimit limit_by_elasticity(const Scene& scene, const Plan& plan, bool changing);

// Sets plan.elastic_rounds, elastic_sub_steps and elastic_choice. explicit_limit: the largest stable sub-step of the
// elastic bodies by linear theory; plan.dt_limit: that of all else [s]. Throws ConfigError when the scene asks for an
// implicit solve that its bodies do not allow.
void plan_elastic_solver(const Scene& scene, double explicit_limit, Plan& plan);

// ", elasticity explicit: ..." or ", elasticity implicit in 40 rounds: ..."; empty without elastic bodies.
std::string describe_elastic_solver(const Plan& plan);

// Elastic bodies that are bonded to nothing.
std::vector<std::uint32_t> free_elastic_bodies(const Scene& scene, const Plan& plan);

}  // namespace palp
