// What a scene needs: which modules run, and the numbers that the accuracy level expands to. Nothing that the plan does
// not name is allocated or launched.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_server/physics/particles.h"
#include "sim_server/scene/scene.h"

namespace palp {

// However few its particles, a scene may have this many cells: they cost little to clear.
inline constexpr double kCellsAtLeast = 65536;

struct Plan {
  // modules
  Method method = Method::accurate;
  bool fluid = false;
  bool one_fluid = false;    // all of one material, what may melt included
  bool solids = false;       // any rigid or fixed particles
  bool wrench = false;       // a body whose wrench is asked for: rigid ones, and fixed ones with a probe
  bool moving = false;       // rigid bodies
  bool contact = false;      // springs between the particles of solids that no distance field serves
  bool fields = false;       // contact by distance fields: of two bodies that have one, or of soft matter with one
  bool elastic = false;      // elastic bodies
  bool plastic = false;      // some of them yield
  bool tears = false;        // some of them tear
  bool meets = false;        // anything whose neighbours change: a fluid, or bodies that can touch
  bool temperature = false;  // carried
  bool heat = false;         // conducted, lost and supplied
  bool change = false;       // matter that melts, freezes or sets
  bool rigidifies = false;   // and becomes rigid
  // numerics
  double support = 0;          // H [m]
  double elastic_support = 0;  // of elastic bodies [m]
  double sound_speed = 0;      // c, of the heaviest fluids [m/s]
  double max_speed = 0;        // expected [m/s]
  double artificial = 0;       // alpha
  double diffusion = 0;        // delta
  bool tension = false;
  bool cohesion = false;          // surface tension or adhesion
  int viscous_stages = 0;         // of a sub-step; 0: viscosity is explicit
  double explicit_sub_steps = 0;  // that explicit viscosity would need
  int elastic_rounds = 0;         // of a sub-step's implicit elastic solve; 0: elasticity is explicit
  double elastic_sub_steps = 0;   // that explicit elasticity would need
  std::string elastic_choice;     // why, in a few words
  int sub_steps = 1;              // per haptic step
  double dt = 0;                  // sub-step [s]
  double dt_limit = 0;            // the largest stable sub-step by linear theory [s]
  std::string limited_by;         // "sound", "viscosity", "surface tension", "elasticity", "damping", "contact"
  double skin = 0;  // how far stored neighbour lists reach past the support radius; 0: none are stored [m]
  // heat runs at the end of every heat_interval-th haptic step, in heat_steps steps of heat_dt
  int heat_interval = 1;
  int heat_steps = 1;
  double heat_dt = 0;     // [s]
  double heat_limit = 0;  // the largest stable step by linear theory [s]
  // changes of state
  double change_support = 0;              // of bonds [m]
  std::uint32_t slots = 0;                // particles that change state, and of bodies that they hold on to
  std::vector<bool> changes;              // per body
  std::vector<std::uint32_t> slot_first;  // per body, kNone
  // cells
  int cells[3] = {1, 1, 1};
  // bodies
  std::vector<std::uint32_t> reactive;  // bodies whose wrench is reduced
  std::vector<std::uint32_t> rigid;     // bodies that move
  std::vector<std::uint32_t> elastic_bodies;
  std::vector<bool> probed;                // per body: somebody asks for its wrench
  std::vector<std::uint32_t> group;        // per body: those bonded to one another share a number
  std::uint32_t elastic_count = 0;         // particles of elastic bodies and those bonded to them: first in force order
  std::uint32_t force_count = 0;           // particles of the reactive bodies
  std::vector<std::uint32_t> force_first;  // per body, kNone
};

// Throws ConfigError when the scene cannot be run as asked: sub_steps unstable, a periodic axis too short, too many
// cells.
// skin_over_spacing: what the back end would like (backend/cpu.cpp); a short periodic axis may leave less.
// cells_per_reach: small cells leave fewer candidates to test, large ones are fewer to visit.
Plan make_plan(const Scene& scene, double skin_over_spacing = 0, int cells_per_reach = 1);

// Lame's constants of an elastic material [Pa].
double shear_modulus(const MaterialConfig& material);
double lame_lambda(const MaterialConfig& material);
double pressure_wave_speed(const MaterialConfig& material);  // [m/s]

// "method accurate, dx 20 mm, H 2.5 dx, c 17.7 m/s, ..." one line.
std::string describe(const Plan& plan, const Scene& scene);

// Of a fluid's material [m/s]. rho0 c^2, which makes a fluid stiff, falls with its density, so that a light one would
// be crushed by the weight of a heavy one: c is raised until it has a tenth of the heaviest one's, which compresses it
// by about 5 % where the heavy one is compressed by 0.5 %.
double sound_speed_in(const Scene& scene, const Plan& plan, const MaterialConfig& material);

// Linear stability limit of c dt / dx for weakly compressible SPH with a Wendland C2 kernel, and of nu dt / dx^2 for
// the Morris viscosity, on a cubic lattice, as functions of H / dx (from the operators' largest eigenvalues).
double acoustic_limit(double support_over_spacing);
double viscous_limit(double support_over_spacing);
// The same of c_p dt / dx for total-Lagrangian elasticity with corrected gradients, c_p being the speed of pressure
// waves.
double elastic_limit(double support_over_spacing);

}  // namespace palp
