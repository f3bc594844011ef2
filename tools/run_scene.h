// The work of palp-run: a scene run as fast as it goes, its probes and particles written to files.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/pose_path.h"
#include "sim_server/solver/health_report.h"

namespace palp {

// The device at `time`: straight between two points and turning evenly, with the twist of that motion. Not engaged
// before the first point; at rest after the last.
DeviceInput device_on_path(const std::vector<PathPose>& path, double time, const CouplingGains& gains);

// The time on a path that begins anew wherever it ends [s]: up to that of its last pose.
double repeated(const std::vector<PathPose>& path, double time);

// Where progress is shown: a terminal has one line that is rewritten, a log gets a line from time to time.
enum class ProgressOn { nothing, terminal, log };

struct RunOptions {
  std::string out;                                  // folder for all files but the recording; empty: there are none
  std::optional<double> duration;                   // [s] of simulated time; else the scene's
  double snapshots_hz = 0;                          // particle files per simulated second; 0: none
  double totals_hz = 0;                             // rows of totals.csv per simulated second; 0: none
  std::map<unsigned, std::vector<PathPose>> paths;  // by the number of the device that they drive
  bool repeat_paths = false;                        // they begin anew where they end
  std::map<unsigned, std::string> hands;  // files of hand scripts, by the device whose simulated arm they move
  std::string record;                     // MCAP file as palp-record writes them; empty: none
  bool overwrite = false;                 // a recording that is there already
  ProgressOn progress = ProgressOn::nothing;
  double progress_period = 10;             // [s] between lines of progress in a log, but the first, which comes sooner
  const std::atomic<int>* stop = nullptr;  // not zero: the signal that asks to stop
};

struct RunResult {
  HealthRecord record;  // of all steps
  std::uint64_t steps = 0;
  double time = 0;       // [s] simulated
  double wall_time = 0;  // [s]
  int stopped_by_signal = 0;
};

// Adds, for each proxy without a path, the hand that the scene names, else one that holds still, where hands has none
// for its device.
void add_hands_of_scene(const SceneConfig& scene, RunOptions& options);

// Runs the simulation from its initial state. Hands run in lock step with it, through arm, loop and coupling. Writes
// NAME.csv for each probe, proxy.csv (proxy_N.csv for device N > 0) for each path, totals.csv, particles_NNNNNN.csv and
// snapshots.csv, and summary.json, also when the simulation turns unhealthy, which ends the run; one whose answer is
// only spoilt goes on; and the recording. Throws std::runtime_error when a file cannot be written and ConfigError when
// there is a path or a hand but no proxy of its device, or both for one, or the duration is below one haptic step.
RunResult run_scene(Simulation& simulation, const RunOptions& options);

}  // namespace palp
