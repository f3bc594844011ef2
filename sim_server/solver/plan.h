// The plan of a scene: which modules run, and the numbers that the accuracy level expands to. Nothing that the plan
// does not name is allocated or launched.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_server/physics/particles.h"
#include "sim_server/scene/scene.h"

namespace palp {

// The number of cells that a scene may have however few its particles: they cost little to clear.
inline constexpr double kMinCellLimit = 65536;

// The largest sub-step that one process of a scene allows.
struct StepLimit {
  double dt = 1e30;        // [s]
  std::string by;          // "sound", "viscosity", "sound and viscosity", "surface tension", "elasticity", "damping",
                           // "contact", "motion", "rounding", "density", "density diffusion"
  std::string of;          // what sets it: "material 'jelly'", "the hand on 'ladle'"
  std::string avoided_by;  // what spares the plan this limit: "implicit solve", "stages"; empty: it holds
  double share = 1;        // what a sub-step may use of it, over numerics.safety
};

// The way in which two bodies push each other, where neither flows.
enum class SolidContact { none, springs, fields };

struct Plan {
  // modules
  Method method = Method::accurate;
  bool fluid = false;
  bool one_fluid = false;    // all fluids, and solids that may melt, are of one material
  bool solids = false;       // any rigid or fixed particles
  bool wrench = false;       // bodies whose wrench is asked for: rigid ones, and fixed ones with a probe
  bool moving = false;       // rigid bodies
  bool contact = false;      // springs between the particles of solids that no distance field serves
  bool fields = false;       // contact by distance fields: of two bodies that have one, or of soft matter with one
  bool geometry = false;     // solids act on fluids by their geometry
  bool walls = false;        // solids act on fluids by their particles
  bool elastic = false;      // elastic bodies
  bool plastic = false;      // some of them yield
  bool tears = false;        // some of them tear
  bool neighbors = false;    // particles whose neighbours change: of a fluid, or of bodies that can touch
  bool temperature = false;  // particles have temperatures
  bool heat = false;         // heat is conducted, lost and supplied
  bool heat_walls = false;   // solids bound it by their geometry
  bool change = false;       // matter that melts, freezes or sets
  bool rigidifies = false;   // some of it becomes rigid
  bool sleeps = false;       // what rests is not computed
  bool shifts = false;       // particles deep in a fluid are kept evenly spread
  // numerics
  double support = 0;          // H [m]
  double elastic_support = 0;  // H of elastic bodies [m]
  double sound_speed = 0;      // c of the heaviest fluids [m/s]
  double max_speed = 0;        // expected [m/s]
  double artificial = 0;       // alpha
  double diffusion = 0;        // delta
  double shift = 0;            // k of particle shifting
  bool tension = false;
  bool cohesion = false;          // surface tension or adhesion
  int viscous_stages = 0;         // stages of a sub-step; 0: viscosity is explicit
  double explicit_sub_steps = 0;  // number that explicit viscosity would need
  int elastic_rounds = 0;         // rounds of a sub-step's implicit elastic solve; 0: elasticity is explicit
  double elastic_sub_steps = 0;   // number that explicit elasticity would need
  std::string elastic_choice;     // the reason for the choice, in a few words
  int sub_steps = 1;              // per haptic step
  double dt = 0;                  // sub-step [s]
  int fluid_interval = 1;         // haptic steps that fluids take at once, in the first of them
  double dt_limit = 0;            // the largest stable sub-step by linear theory [s]
  double dt_allowed = 0;          // the largest one that all limits allow [s]
  StepLimit ruling;               // the limit that sets dt_allowed
  std::vector<StepLimit> limits;  // all that the scene has, in no order
  double skin = 0;  // length by which stored neighbour lists reach past the support radius; 0: none are stored [m]
  // heat runs at the end of every heat_interval-th haptic step, in heat_steps steps of heat_dt
  int heat_interval = 1;
  int heat_steps = 1;
  double heat_dt = 0;      // [s]
  double heat_limit = 0;   // the largest stable step by linear theory [s]
  int sleep_interval = 1;  // haptic steps from one judgement of what sleeps to the next
  int layer_interval = 1;  // haptic steps from one look at the layers of particles to the next (shift.h)
  // changes of state
  double change_support = 0;              // H of bonds [m]
  std::uint32_t slots = 0;                // particles that change state, and of bodies that they are bonded to
  std::vector<bool> changes;              // per body
  std::vector<std::uint32_t> slot_first;  // per body, kNone
  // cells
  int cells[3] = {1, 1, 1};
  // bodies
  std::vector<std::uint32_t> reactive;  // bodies whose wrench is reduced
  std::vector<std::uint32_t> rigid;     // bodies that move
  std::vector<std::uint32_t> elastic_bodies;
  std::vector<bool> probed;                // per body: a probe asks for its wrench
  std::vector<std::uint32_t> group;        // per body: those bonded to one another share a number
  std::uint32_t elastic_count = 0;         // particles of elastic bodies and those bonded to them: first in force order
  std::uint32_t force_count = 0;           // particles of those and of the reactive bodies
  std::vector<std::uint32_t> force_first;  // per body, kNone
};

// Makes the plan of a scene. skin_over_spacing: the skin that the back end asks for (backend/cpu.cpp); a short periodic
// axis may leave less. cells_per_reach: small cells leave fewer candidates to test, large ones are fewer to visit.
// Throws ConfigError when the scene cannot be run as asked: sub_steps unstable, a periodic axis too short, too many
// cells.
Plan make_plan(const Scene& scene, double skin_over_spacing = 0, int cells_per_reach = 1);

// Returns how two bodies of the scene touch: by springs between their particles, by distance fields, or not at all: one
// of them flows, neither moves, or they are bonded to each other. The plan's bodies must be planned.
SolidContact contact_between(const Scene& scene, const Plan& plan, std::size_t a, std::size_t b);

// Returns the largest speed that the scene's own motion can reach, zero where nothing moves [m/s]: a free fall of the
// fluid (of the bodies where there is none), twice that where it runs off, the initial speeds, what a body force
// drives, and a hand.
double expected_speed(const Scene& scene);

// Returns the relative compression that the sound speed promises of a fluid at the largest expected speed; one that
// rests at the depth from which it would fall at that speed has half of it.
double expected_compression(const Plan& plan);

// Returns one line: "method accurate, dx 20 mm, H 2.5 dx, c 17.7 m/s, ...".
std::string describe(const Plan& plan, const Scene& scene);

}  // namespace palp
