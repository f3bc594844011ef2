// A simulated hand on a simulated arm with the bridge's loop, in lock step with a simulation: what palp-haptic-bridge
// and the server's treatment of its samples do, coupling included, without bus, threads or a clock. The same calls give
// the same motion, bit for bit.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "idl/messages.h"
#include "sim_server/solver/simulation.h"

namespace palp {

class HandInStep {
 public:
  // device: its number. script: file of the hand script (config/hands/README.md), whose keyframes are offsets from
  // `handle`, where the tool's handle is at the start. The arm is that of the profile `simulated`. Throws ConfigError.
  HandInStep(std::uint32_t device, const std::string& script, const RigidState& handle);
  ~HandInStep();
  HandInStep(HandInStep&&) noexcept;
  HandInStep& operator=(HandInStep&&) noexcept;

  // Lets arm and loop run up to `time` [s], at 1 kHz, and returns the device for a step of `step` seconds that begins
  // then. proxy: where the handle is. Times grow from call to call.
  DeviceInput input(double time, double step, const RigidState& proxy);
  // Returns the server's answer after that step, which the loop's next tick takes in. ok: the simulation is sound.
  ProxySample answer(const ProxyOutput& proxy, bool ok, double time);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palp
