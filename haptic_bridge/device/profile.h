// A device profile and a hand script, read strictly from TOML. The grammar, units and ranges stand in
// config/devices/README.md and config/hands/README.md.
#pragma once

#include <string>

#include "haptic_bridge/device/simulated.h"
#include "haptic_bridge/device/spacenav.h"
#include "haptic_bridge/device/virtuose/session.h"
#include "haptic_bridge/loop/loop.h"

namespace palp {

// Without a file: limits that suit any arm.
struct DeviceProfile {
  std::string name = "built-in defaults";
  LoopConfig loop;            // its limits, gains, safety, passivity and workspace
  ArmModel arm;               // of the simulated device; others have none
  SpacenavSetup spacenav;     // of the 3D mouse
  bool for_virtuose = false;  // it has a table [virtuose]
  VirtuoseSetup virtuose;     // library, address, mode, device type, relay time, axes
};

// Both throw ConfigError with every fault of the file, file:line each.
DeviceProfile read_device_profile(const std::string& path);
HandScript read_hand_script(const std::string& path);

// The grips of section "grip" by name: "off", "light", "firm".
inline constexpr HandModel kHandsOff{0, 0.5, 20};
inline constexpr HandModel kLightGrip{0.15, 3, 100};
inline constexpr HandModel kFirmGrip{0.5, 10, 500};

}  // namespace palp
