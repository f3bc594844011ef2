// A haptic device as the loop sees it. Opening is construction (throws ConfigError or std::runtime_error with one
// sentence); closing is destruction, which leaves the device without force.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "haptic_bridge/loop/loop_state.h"
#include "idl/coupling.h"

namespace palp {

// The box that the handle can be moved in, along the world's axes, in the space of the device's poses [m].
struct DeviceReach {
  Eigen::Vector3d center, half;
};

struct DeviceInfo {
  std::string name;
  double force_limit = 0;              // most that it can render [N]
  double torque_limit = 0;             // [N m]
  bool renders_force = true;           // false: a wrench has no effect (replay)
  std::optional<DeviceReach> reach{};  // unset: not known
};

// The state of a device as it was read, world frame, about the handle.
struct DeviceReading {
  RigidState state;
  bool dead_man = false;      // the hand holds the handle
  bool powered = false;       // the motors can render force
  bool chain_closed = false;  // of the emergency stop
  bool shifted = false;       // indexing: the hand moves the arm and not the tool
  bool strained = false;      // at a bound, overheating or saturated: the force is to be halved
  std::uint32_t alarms = 0;   // as the device numbers them, for the log
  std::uint32_t buttons = 0;  // bit n: button n
  bool engaged() const { return dead_man && powered && chain_closed && !shifted; }
};

class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  virtual const DeviceInfo& info() const noexcept = 0;
  // Gives the state at now_ns (the loop's clock; a real arm reads its own). False: no reading this tick. Simulated
  // devices: no allocation, no lock, no system call.
  virtual bool read(std::int64_t now_ns, DeviceReading& out) noexcept = 0;
  // Sets the wrench on the hand until the next call. False: it was not taken.
  virtual bool write(const Wrench<double>& wrench) noexcept = 0;
  // Leaves the hand without force after the last tick, whatever ended the loop, and takes the power off where there are
  // motors. The log is written afterwards, and an arm would hold its last wrench meanwhile.
  virtual void release() noexcept { write({Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}); }
  // Shows the device what the loop makes of this tick, after write: the lamp of an arm, the eyes of a simulated hand.
  // Simulated devices: no allocation, no lock, no system call.
  virtual void show(LoopState) noexcept {}
  // One sentence about what went wrong with the device itself, or empty. Not while a loop runs.
  virtual std::string trouble() const { return {}; }
};

}  // namespace palp
