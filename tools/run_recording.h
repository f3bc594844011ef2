// A recording of a run in simulated time: what a server would send, as palp-record would write it, without a bus.
#pragma once

#include <string>
#include <vector>

#include "idl/mcap/sample_writer.h"
#include "sim_server/solver/simulation.h"

namespace palp {

// Times in the file are those of the simulation, from 0. The same run gives the same bytes.
class RunRecording {
 public:
  // Writes the scene's description. Throws McapError when the file exists, unless overwrite, or cannot be written.
  RunRecording(const Simulation& simulation, const std::string& path, bool overwrite);

  // Writes the state after a step, or the initial one: what the server would answer to the hands, and a frame of
  // particles with the poses of bodies where one is due at the scene's particle_rate_hz.
  void write_state(Simulation& simulation, const StepOutput& output, std::vector<ProxySample> answers = {});
  void close();
  const McapStatistics& statistics() const { return writer_.statistics(); }

 private:
  void write_frame(Simulation& simulation, const StepOutput& output);

  SampleWriter writer_;
  Frame frame_;
  std::uint64_t frames_ = 0;
};

}  // namespace palp
