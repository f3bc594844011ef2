// A run of the loop kept in a file with all that it took in, and run again: to find out why it did what it did, and
// that a change of the loop changes nothing.
//
// The file is binary, little-endian, every value eight bytes: the magic word, the number of ticks, the loop's
// configuration, then each tick's input and what came of it (wrench sent, state, gains).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "haptic_bridge/log/flight_log.h"
#include "haptic_bridge/log/output_file.h"

namespace palp {

// Writes what the log holds to a file beside the path and renames it. Throws std::runtime_error with one sentence. Not
// while the loop runs.
void write_ticks(const FlightLog& log, const LoopConfig& config, const std::string& path);

// Returns the path of a run's file beside its flight log: the same name with .ticks.
std::string ticks_beside(const std::string& flight_log);

// Writes the flight log as CSV and the run beside it, and marks the log as written. Throws as write_ticks.
void write_log_and_run(const FlightLog& log, const LoopConfig& config, const std::string& flight_log);
// Reserves room on the disk for the flight log and the run, of so many ticks.
struct LogRoom {
  LogRoom(const std::string& flight_log, std::size_t ticks);
  ReservedRoom csv, run;
};

// The outcome of a tick, which a second run must give again.
struct TickResult {
  Wrench<double> sent = zero_wrench();
  LoopState state = LoopState::waiting;
  double gains_share = 1;  // that the governor allows
};

struct KeptRun {
  LoopConfig config;
  std::uint64_t first_tick = 1;  // counted from 1
  std::vector<TickInput> inputs;
  std::vector<TickResult> results;
};

// Reads the file of a run. Throws ConfigError with one sentence about what is wrong with it.
KeptRun read_ticks(const std::string& path);

struct Rerun {
  std::uint64_t ticks = 0;
  std::uint64_t differs_at = 0;  // first tick whose wrench, state or gains are not the same, bit for bit; 0: none
  TickResult then, now;          // in that tick
};

// Runs the loop again. The run must hold the loop's first tick. Throws ConfigError if not.
Rerun run_again(const KeptRun& run);

// "N ticks, identical", or which tick differs and how.
std::string to_text(const Rerun& rerun);

}  // namespace palp
