// All that a tick of the loop takes in. The same inputs give the same wrenches, bit for bit, so a run that was kept can
// be run again (rerun.h). Plain data.
#pragma once

#include <cstdint>

#include "haptic_bridge/loop/haptic_device.h"
#include "haptic_bridge/loop/sample_gate.h"

namespace palp {

struct TickInput {
  std::int64_t now_ns = 0;
  std::int64_t lateness_ns = 0;
  std::uint32_t missed = 0;
  LoopFault told = LoopFault::none;  // from outside, before the tick
  std::uint64_t refused = 0;         // samples that were too malformed to be handed on
  bool came = false;                 // a sample
  IncomingProxy incoming;            // it; else whatever came last
  bool was_read = false;             // the device gave the reading
  DeviceReading reading;             // as the device left it
  bool was_written = false;
};

}  // namespace palp
