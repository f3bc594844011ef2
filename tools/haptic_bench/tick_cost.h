// Measures what a tick of the bridge's loop costs: run_loop on a clock that does not wait, each tick measured in CPU
// time of its thread.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "haptic_bridge/device/profile.h"
#include "haptic_bridge/device/simulated.h"

namespace palp::bench {

struct TickCost {
  std::string device;
  std::size_t ticks = 0;
  double median_us = 0, p99_us = 0, max_us = 0;  // CPU time, two readings of its clock included
  std::size_t over = 0;   // ticks above 20 us, which on a machine with other work are those with an interrupt
  double share_felt = 0;  // of the ticks, with force
};

// Returns the cost of the loop alone (a device that does nothing) and with the simulated arm, the simulated Virtuose
// (library: a path) and a replayed path. Each tick has a new sample of a wall that the tool is pressed into; motion and
// force are scaled, and every limit is on. Throws what the devices throw.
std::vector<TickCost> tick_costs(const DeviceProfile& profile, const std::string& virtuose_library, std::size_t ticks);

// Returns the costs as a table.
std::string markdown(const std::vector<TickCost>& costs);

}  // namespace palp::bench
