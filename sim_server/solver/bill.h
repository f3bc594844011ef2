// The bill of a scene: what is computed, why, and what each part of it costs. Host only, for people and tests.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_server/solver/plan.h"
#include "sim_server/solver/simulation.h"

namespace palp {

struct BillBody {
  std::string name, kind;  // kind: "fluid", "elastic", "rigid", "static"
  std::uint32_t particles = 0;
  // The uses of its particles: "fluid", "wall of a fluid", ...; empty: nobody meets them.
  std::vector<std::string> reasons;
  // Those of a static body that lie farther than the support radius from where fluid can get while it stays within the
  // static bodies' bounds. Zero in scenes where particles have other uses.
  std::uint32_t out_of_reach = 0;
};

struct BillModule {
  std::string name, why;  // why: what of the scene asks for it
};

struct BillLimit {
  StepLimit limit;
  double sub_steps = 1;  // that it alone would ask for in a haptic step, at the scene's safety
};

struct BillStage {
  std::string name;
  std::uint64_t launches = 0;  // in a haptic step that has it
  std::uint64_t every = 1;     // it runs in one haptic step of so many
  double seconds = 0;          // of a haptic step, on average, as measured [s]
  double share = 0;            // of the time of all stages
};

struct Bill {
  std::string scene, numerics, backend;
  double spacing = 0;  // [m]
  std::vector<BillBody> bodies;
  std::vector<BillModule> modules;
  int sub_steps = 1;
  double step = 0;                // haptic step [s]
  double dt = 0;                  // sub-step [s]
  std::vector<BillLimit> limits;  // those that hold first, by what they allow; then those that are avoided
  std::vector<std::pair<std::string, std::size_t>> arrays;  // name, bytes
  std::vector<BillStage> stages;                            // in the order of a step
  std::uint64_t measured_steps = 0;                         // haptic steps that shares were measured over
  std::vector<std::string> hints;                           // what would make it cheaper, one sentence each

  std::uint64_t particles() const;
  std::size_t bytes() const;
  double stage_seconds() const;  // of a haptic step, as measured
};

// Makes what follows from the scene and its plan: a bill without stages and hints, with no measured steps.
Bill planned_bill(const Simulation& simulation);

// Makes the bill of a simulation, which it steps for at least so long [s of wall time] to measure its stages.
Bill make_bill(Simulation& simulation, double seconds);

// Return the parts of a bill that follow from the scene and its plan.
std::vector<BillBody> bill_bodies(const Scene& scene, const Plan& plan);
std::vector<BillModule> bill_modules(const Scene& scene, const Plan& plan);
std::vector<BillLimit> bill_limits(const Scene& scene, const Plan& plan);
// The bill's other parts are ready.
std::vector<std::string> bill_hints(const Scene& scene, const Plan& plan, const Bill& bill);

}  // namespace palp
