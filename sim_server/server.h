// The server: steps the simulation at the haptic rate and lets the bus know. The simulation's thread touches no DDS:
// device samples come and proxy samples go through mailboxes, frames and status through threads of their own.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "config/json_file.h"
#include "idl/bus.h"
#include "sim_server/solver/health_report.h"

namespace palp {

struct ServerOptions {
  double seconds = 0;                // wall time after which to stop; 0: never
  bool as_fast_as_possible = false;  // no pacing, for tests
  bool start_paused = false;
};

// Some of a run's steps.
struct StepShare {
  std::uint64_t steps = 0;
  double p50_us = 0, p99_us = 0, max_us = 0;
};

// The scenes that a server goes over to when it is told to.
struct SceneChoice {
  std::vector<std::string> names;
  // Opens one of them, or, with an empty name, the scene that is served, read anew. Throws what says why it cannot.
  std::function<std::unique_ptr<Simulation>(const std::string& name)> open;
};

// The figures of a run, for the summary and for the exit status.
struct ServerSummary {
  std::uint64_t steps = 0;
  double sim_time = 0, wall_time = 0;  // [s] stepped, across resets; and of the clock, while not paused
  double step_p50_us = 0, step_p99_us = 0, step_max_us = 0;
  StepShare beside_viewers, without_viewers;        // while a viewer drew on the same GPU, and while none did
  double handover_p50_us = 0, handover_p99_us = 0;  // what talking to the bus costs the simulation's thread, per step
  std::uint64_t slow_steps = 0;                     // that took longer than the haptic period
  std::uint64_t frames = 0, shared_frames = 0;      // sent over the bus; and by shared memory
  std::uint64_t dropped_samples = 0;                // device samples and commands refused
  HealthRecord record;
  double real_time_factor() const { return wall_time > 0 ? sim_time / wall_time : 0; }
};

struct Served {
  ServerSummary summary;
  std::unique_ptr<Simulation> next;  // of the scene to go over to; null: the run is over
  bool paused = false;               // the simulation stood still at the end
};

// Runs until stop, a quit command, the time is up or another scene has been opened. A diverging simulation stops
// stepping, says why in an event, and waits for reset, another scene or quit; the summary keeps it. While a scene is
// opened the simulation stands still.
Served serve(Simulation& simulation, Bus& bus, const ServerOptions& options, const SceneChoice& scenes,
             const std::atomic<int>& stop);

Json json_of(const ServerSummary& summary, const Simulation& simulation);

}  // namespace palp
