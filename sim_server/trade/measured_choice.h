// The choice by a curve, corrected by what this machine does today: candidates are timed until one keeps its word.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim_server/trade/trade_table.h"

namespace palp {

// The purpose that numerics are chosen for: one of the two.
struct ChoiceRequest {
  // The most that a haptic step may take [s], on the mean: a late step is made up for within a few periods, so the mean
  // decides whether a server keeps up. The median does not: it jumps by half, once every other step lists neighbours.
  std::optional<double> budget;
  std::optional<double> error;  // the most that the force may be off, rms over rms
  bool asked() const { return budget || error; }
};

// Returns the median step of the scene with these numerics on this machine while each hand holds still [s]. Throws
// ConfigError when the scene cannot be had so: at some spacings a thin part falls between the particles of a lattice.
using TimeCandidate = std::function<double(const TradePoint&)>;

struct MeasuredChoice {
  TradePoint point;  // its times are those expected on this machine
  double speed = 1;  // of this machine over that of the table, with these numerics
};

// Returns, for a budget, the point with the least error whose expected step fits; for an error, the cheapest that is
// expected to err no more. trusted: the curve was measured with this scene on such a machine, so that the first
// candidate is likely to do; else the cheapest point is timed first. A candidate that the scene cannot be had with is
// moved along the curve, for a budget to coarser particles, for an error to finer ones. Throws ConfigError, which says
// what would be possible, when nothing on the curve does. scene: its name, for that message.
MeasuredChoice choose_measured(const std::vector<TradePoint>& points, const ChoiceRequest& request, bool trusted,
                               const std::string& scene, const TimeCandidate& time_candidate);

}  // namespace palp
