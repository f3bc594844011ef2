// The states and faults of the loop, in words that the log, the status and the device share.
#pragma once

#include <cstdint>

namespace palp {

enum class LoopState : std::uint32_t {
  waiting = 0,  // no usable sample of a server yet
  ready,        // samples come; they have not been fresh for long enough
  engaged,      // force, perhaps still on its ramp
  idle,         // the hand is off, or the simulation is paused, unhealthy or not coupled to this device
  degraded,     // samples are late: force is fading into damping
  stale,        // no sample for too long: no force
  locked,       // force was cut: the hand must let go of the handle and take hold again
  fault,        // the device failed: no force, for good
};
const char* to_string(LoopState state);

enum class LoopFault : std::uint32_t {
  none = 0,
  device_read,
  device_write,
  not_finite,
  taken_for_dead,  // it stood still, so the supervisor took the arm's power
  unguarded,       // the supervisor has died or was stopped
};
// Returns one sentence about the fault, for people.
const char* to_string(LoopFault fault);

}  // namespace palp
