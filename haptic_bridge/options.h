// The command line of haptic_bridge.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "config/program.h"
#include "haptic_bridge/device/driver.h"
#include "haptic_bridge/guard/realtime.h"
#include "idl/bus.h"
#include "idl/coupling.h"

namespace palp {

struct BridgeOptions {
  const Driver* driver = nullptr;  // of the device
  DriverOptions driver_options;    // as given
  std::uint32_t device_number = 0;
  std::string profile;             // TOML; empty: built-in defaults
  std::optional<RigidState> home;  // at rest; none: from the scene
  double rate_hz = 1000;
  double seconds = 0;   // 0: until stopped
  std::string log;      // CSV file
  std::string rerun;    // a kept run: to be run again, and nothing else
  std::string summary;  // JSON file
  double log_seconds = 60;
  RealtimeOptions realtime;
  // How long this machine's lateness is measured at the start [s]; none: it depends on whether the device has motors.
  std::optional<double> self_test;
  bool full_force = false;  // whatever the self-test says
  // override the profile's
  std::optional<double> stiffness, damping, angular_stiffness, angular_damping, motion_scale, force_scale;
  BusOptions bus;
};

// Reads the command line. Throws ConfigError where options do not go together.
Parsed<BridgeOptions> parse_options(int argc, char** argv);

}  // namespace palp
