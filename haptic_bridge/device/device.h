// A haptic device as the loop sees it. Opening is construction (throws ConfigError or std::runtime_error with one
// sentence); closing is destruction, which leaves the device without force.
#pragma once

#include <cstdint>
#include <string>

#include "idl/coupling.h"

namespace palp {

struct DeviceInfo {
  std::string name;
  double force_limit = 0;     // most that it can render [N]
  double torque_limit = 0;    // [N m]
  bool renders_force = true;  // false: a wrench has no effect (replay)
};

// World frame, about the handle.
struct DeviceReading {
  HandleState<double> state;
  bool engaged = false;       // the hand holds the handle, the power is on, force is wanted
  std::uint32_t buttons = 0;  // bit n: button n
};

class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  virtual const DeviceInfo& info() const noexcept = 0;
  // The state at now_ns (the loop's clock; a real arm reads its own). False: no reading this tick.
  // Simulated devices: no allocation, no lock, no system call.
  virtual bool read(std::int64_t now_ns, DeviceReading& out) noexcept = 0;
  // The wrench on the hand until the next call. False: it was not taken.
  virtual bool write(const Wrench<double>& wrench) noexcept = 0;
};

}  // namespace palp
