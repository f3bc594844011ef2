// The plan of time: how long a sub-step may be, by linear theory and by contact, and how many make a haptic step.
#pragma once

#include "sim_server/solver/plan.h"

namespace palp {

// Sets what the plan says of sub-steps, and with it whether elasticity and viscosity are solved implicitly or in
// stages. Modules, bodies, support radii and speeds must be planned. Throws ConfigError when the scene cannot be run as
// asked.
void plan_sub_steps(const Scene& scene, Plan& plan);

// Sets how many haptic steps fluids take at once. All else of the plan but sleep must be planned. Throws ConfigError
// when the scene asks for more than its fluids can take.
void plan_fluid_interval(const Scene& scene, Plan& plan);

// Returns the longest sub-step that a limit allows [s]: numerics.safety times its share of it, but no more than it is.
double allowed_by(const StepLimit& limit, const NumericsConfig& numerics);

// Adds a limit to those of the plan, which it rules if it allows least and nothing avoids it. One of 1e30 s is none.
void limit_by(const StepLimit& limit, const NumericsConfig& numerics, Plan& plan);

// Returns the haptic steps from one to the next of what is done about every `interval` seconds, in steps in which
// fluids move: at least as many as they take at once.
int steps_between(double interval, const Scene& scene, const Plan& plan);

// Return the linear stability limits of c dt / dx for weakly compressible SPH, and of nu dt / dx^2 for the Morris
// viscosity, on a cubic lattice, as functions of H / dx (from the operators' largest eigenvalues).
double acoustic_limit(double support_over_spacing, KernelType kernel);
double viscous_limit(double support_over_spacing, KernelType kernel);
// Returns that of nu dt / dx^2 for the viscosity of method "paper" (Mueller, Charypar & Gross 2003).
double laplacian_limit(double support_over_spacing);
// Returns the limit of c_p dt / dx for total-Lagrangian elasticity with corrected gradients, c_p being the speed of
// pressure waves. The forces against hourglass modes, which take up to a fifth off it, count in elastic_limit.h.
double elastic_limit(double support_over_spacing);

}  // namespace palp
