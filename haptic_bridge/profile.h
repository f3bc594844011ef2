// A device profile and a hand script, read strictly from TOML. The grammar, units and ranges stand in
// config/devices/README.md and config/hands/README.md.
#pragma once

#include <string>

#include "haptic_bridge/device/simulated.h"
#include "haptic_bridge/device/spacenav.h"
#include "haptic_bridge/loop.h"
#include "haptic_bridge/virtuose/session.h"
#include "idl/messages.h"

namespace palp {

// Without a file: limits that suit any arm.
struct DeviceProfile {
  std::string name = "built-in defaults";
  WrenchLimits limits;
  CouplingGains gains{1000, 20, 10, 0.2};
  SafetyConfig safety;
  PassivityConfig passivity = LoopConfig{}.passivity, angular_passivity = LoopConfig{}.angular_passivity;
  WorkspaceConfig workspace;
  ArmModel arm;               // of the simulated device; others have none
  SpacenavSetup spacenav;     // of the 3D mouse
  bool for_virtuose = false;  // it has a table [virtuose]
  VirtuoseSetup virtuose;     // library, address, mode, device type, relay time, axes
};

// Both throw ConfigError with every fault of the file, file:line each.
DeviceProfile read_device_profile(const std::string& path);
HandScript read_hand_script(const std::string& path);

// The loop's configuration with what the profile says of it.
inline LoopConfig loop_config(const DeviceProfile& profile) {
  LoopConfig config;
  config.gains = profile.gains;
  config.limits = profile.limits;
  config.safety = profile.safety;
  config.passivity = profile.passivity;
  config.angular_passivity = profile.angular_passivity;
  config.workspace = profile.workspace;
  return config;
}

// The grips of section "grip" by name: "off", "light", "firm".
inline constexpr HandModel kHandsOff{0, 0.5, 20};
inline constexpr HandModel kLightGrip{0.15, 3, 100};
inline constexpr HandModel kFirmGrip{0.5, 10, 500};

}  // namespace palp
