// The command line of haptic_bridge.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "haptic_bridge/device/virtuose/session.h"
#include "haptic_bridge/guard/realtime.h"
#include "idl/bus.h"
#include "idl/coupling.h"
#include "idl/messages.h"

namespace palp {

enum class DeviceKind { simulated, replay, virtuose, spacenav };

struct BridgeOptions {
  DeviceKind device = DeviceKind::simulated;
  std::uint32_t device_number = 0;
  std::string profile;  // TOML; empty: built-in defaults
  std::string hand;     // TOML; empty: holds still
  std::string path;     // CSV of the replay device
  bool loop_path = false;
  std::string library;  // of the Virtuose or the 3D mouse; empty: the profile's
  std::string address;
  std::optional<VirtuoseMode> virtuose_mode;
  std::optional<RigidState> home;  // at rest; none: from the scene
  double rate_hz = 1000;
  double seconds = 0;   // 0: until stopped
  std::string log;      // CSV file
  std::string rerun;    // a kept run: to be run again, and nothing else
  std::string summary;  // JSON file; empty: beside the log
  double log_seconds = 60;
  RealtimeOptions realtime;
  std::optional<double> self_test;  // how long this machine's lateness is measured at the start [s]; none: 5 for an arm
  bool full_force = false;          // whatever the self-test says
  // override the profile's
  std::optional<double> stiffness, damping, angular_stiffness, angular_damping, motion_scale, force_scale;
  BusOptions bus;
};

// The options, or none and the exit status: help was printed (0) or what is wrong with them (not 0).
struct ParsedOptions {
  std::optional<BridgeOptions> options;
  int exit_status = 0;
};
ParsedOptions parse_options(int argc, char** argv);

}  // namespace palp
