// Adds the time of stages up, of which each lasts until the next one begins. For a back end, while it is asked for.
#pragma once

#include <algorithm>
#include <string>

#include "sim_server/solver/simulation.h"

namespace palp {

// Returns the entry of a stage, made at its first call.
inline StageTimes::Stage& stage_of(StageTimes& times, const std::string& name) {
  const auto found = std::find_if(times.stages.begin(), times.stages.end(),
                                  [&](const StageTimes::Stage& stage) { return stage.name == name; });
  if (found != times.stages.end()) return *found;
  times.stages.push_back({name, 0, 0});
  return times.stages.back();
}

inline void add_launch(StageTimes& times, const std::string& name, double seconds) {
  StageTimes::Stage& stage = stage_of(times, name);
  stage.seconds += seconds;
  ++stage.launches;
}

}  // namespace palp
