// The files that palp-run writes beside those of the scene's probes.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "config/csv_file.h"
#include "config/json_file.h"
#include "idl/histogram.h"
#include "sim_server/probes/penetration.h"
#include "sim_server/probes/probes.h"

namespace palp {

// Writes what a driven proxy feels, step by step: its handle, force and torque on the device, and those of contact.
class ProxyFile {
 public:
  explicit ProxyFile(const std::string& path);
  void write(double time, const ProxyOutput& proxy);
  void close() { file_.close(); }

 private:
  CsvFile file_;
};

// Writes sums over the scene, by which runs are compared: energy, heat and temperatures as the probes of these names
// give them, momentum [N s] and angular momentum about the origin [N m s] of all that moves, the volume of its fluids
// [m^3], and how deep particles lie in solids (penetration.h) [m].
class TotalsFile {
 public:
  TotalsFile(const Scene& scene, const std::string& path);  // keeps a reference to the scene
  // The output of a step, not the initial state.
  void write(const Snapshot& snapshot, const StepOutput& output);
  void close() { file_.close(); }

 private:
  void add_motion(const Snapshot& snapshot, const StepOutput& output, ProbeRow& row) const;

  const Scene& scene_;
  ProbeSampler sampler_;
  PenetrationMeter penetration_;
  ProbeConfig energy_, heat_;
  CsvFile file_;
};

// Counts what each step of a run costs, without probes and files, in room that does not grow with the run.
class StepTimes {
 public:
  // Runs one step. Times its own thread's wall clock, and the processor time of the whole process, threads included.
  template <class Step>
  void measure(Step&& step) {
    const Now begin = now();
    step();
    const Now end = now();
    wall_.add(end.wall - begin.wall);
    cpu_.add(end.cpu - begin.cpu);
    sum_ns_ += end.wall - begin.wall;
  }
  // Returns medians, other quantiles, the steps a second that the machine reached and, with the haptic rate of the
  // scene [Hz], how fast simulated time passed; times in seconds, quantiles rounded up by at most 0.4 %. Null where
  // there was no step.
  Json summary(double rate_hz) const;

 private:
  struct Now {
    std::int64_t wall, cpu;  // [ns]
  };
  static Now now();

  FineHistogram wall_, cpu_;
  std::int64_t sum_ns_ = 0;
};

}  // namespace palp
