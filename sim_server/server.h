// The server: steps the simulation at the haptic rate and lets the bus know. The simulation's thread touches no DDS:
// device samples come and proxy samples go through mailboxes, frames and status through threads of their own.
#pragma once

#include <atomic>
#include <memory>
#include <string>

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

// The figures of a run, for the summary and for the exit status.
struct ServerSummary {
  std::uint64_t steps = 0;
  double sim_time = 0, wall_time = 0;  // [s] stepped, across resets; and of the clock, while not paused
  double step_p50_us = 0, step_p99_us = 0, step_max_us = 0;
  StepShare beside_viewers, without_viewers;        // while a viewer drew on the same GPU, and while none did
  double handover_p50_us = 0, handover_p99_us = 0;  // what talking to the bus costs the simulation's thread, per step
  std::uint64_t slow_steps = 0;                     // that took longer than the haptic period
  std::uint64_t frames = 0;
  std::uint64_t dropped_samples = 0;  // device samples and commands refused
  HealthRecord record;
  double real_time_factor() const { return wall_time > 0 ? sim_time / wall_time : 0; }
};

// Runs until stop, a quit command or the time is up. A diverging simulation stops stepping, says why in an event, and
// waits for reset or quit; the summary keeps it.
ServerSummary serve(Simulation& simulation, Bus& bus, const ServerOptions& options, const std::atomic<int>& stop);

Json json_of(const ServerSummary& summary, const Simulation& simulation);

}  // namespace palp
