// Every constant that the kernels get from the materials of a scene and from its plan. Host only.
#pragma once

#include "sim_server/physics/cohesion.h"
#include "sim_server/physics/contact_law.h"
#include "sim_server/physics/heat.h"
#include "sim_server/physics/state_change.h"
#include "sim_server/solver/plan.h"

namespace palp {

// Return Lame's constants mu and lambda of an elastic material [Pa], and the speed of its pressure waves [m/s].
double shear_modulus(const MaterialConfig& material);
double lame_lambda(const MaterialConfig& material);
double pressure_wave_speed(const MaterialConfig& material);

// Returns the sound speed in a fluid's material [m/s]. rho0 c^2, which makes a fluid stiff, falls with its density, so
// that a light one would be crushed by the weight of a heavy one: c is raised until rho0 c^2 is a tenth of the heaviest
// one's, which compresses the light one by about 5 % where the heavy one is compressed by 0.5 %.
double sound_speed_in(const Scene& scene, const Plan& plan, const MaterialConfig& material);

// Returns the damping of an elastic material [Pa s]. Method "paper" adds 0.01 rho c dx, c = sqrt(E / rho), since its
// elasticity feeds motion: a neighbourhood's rotation is found with weights W and its strain with gradW, so that the
// forces are no energy's gradient, and at surfaces vibrations of a few spacings grow by up to 0.009 c / dx. In all
// clamped blocks that were tried this damping ended it, a third of it not in all (tools/papers_elasticity.py).
double elastic_damping(const Scene& scene, const Plan& plan, const MaterialConfig& m);

// Returns whether all particles are of one fluid, so that LoneFluid (fluid.h) serves.
bool is_uniform(const Scene& scene, const Plan& plan);

Medium make_medium(const Scene& scene, const Plan& plan);
CohesionMedium make_cohesion_medium(const Scene& scene, const Plan& plan);
HeatMedium make_heat_medium(const Scene& scene, const Plan& plan);      // the plan has heat
ChangeMedium make_change_medium(const Scene& scene, const Plan& plan);  // the plan has changes of state

// kappa and gamma of physics/contact_law.h.
struct BounceCoefficients {
  double stiffness = 0, damping = 0;
};

// Returns the coefficients with which a ball bounces with this restitution, 0 to 1, on the mean over the moments within
// a sub-step at which it may arrive, and never with more than 1. Below about 0.1 it is as small as stable damping makes
// it. implicit: for contact of a tool in a hand with fixed bodies.
BounceCoefficients bounce_coefficients(double restitution, bool implicit);

// Returns the law of contact between two materials: static and kinetic friction are the geometric mean of the
// materials', restitution is the smaller one.
ContactLaw contact_law(const MaterialConfig& a, const MaterialConfig& b, bool implicit);

// Returns the law for a soft body, whose particles touch another body.
ContactLaw soft_contact_law(const MaterialConfig& soft, const MaterialConfig& other);

}  // namespace palp
