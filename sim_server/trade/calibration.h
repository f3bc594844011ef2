// How fast this machine is today: steps of a simulation timed for a fraction of a second.
#pragma once

#include <functional>

#include "sim_server/solver/simulation.h"

namespace palp {

// How long steps are timed. A time counts only what the steps took.
struct Timing {
  double warm_up = 0.05;    // neighbour lists, graphs, clocks and caches settle [s]
  int least_warm_up = 3;    // steps
  double seconds = 0.25;    // [s]
  int least_steps = 15;     // so that a long step has a median, too
  double most_seconds = 3;  // [s] after which fewer steps must do, down to three
};

// Returns the median of what steps take [s]: a moment in which the machine was elsewhere moves it by no more than its
// share of the steps. timed_step takes a step and returns how long it took [s]; it is called after the warm-up at least
// three times.
double typical_step(const std::function<double()>& timed_step, const Timing& timing = {});

// Hands that hold their tools where these are at the start.
StepInput still_hands(const Scene& scene);

// Returns what a haptic step of a simulation typically takes from where it is, with still hands, on the mean over those
// that fluids take at once [s]. Throws std::runtime_error when it turns
// unhealthy meanwhile.
double calm_step(Simulation& simulation, const Timing& timing = {});

}  // namespace palp
