// The script of a simulated hand, which says what the hand does. It is read strictly from TOML; the grammar, units and
// ranges stand in config/hands/README.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "haptic_bridge/device/trajectory.h"

namespace palp {

struct HandModel {
  double mass = 0.5;       // moves with the handle [kg]
  double damping = 10;     // between the handle and where the hand wants it [N s/m]
  double stiffness = 500;  // [N/m]
  double lever = 0.1;      // half width of the grip: its rotational mass, damping, stiffness are those above times
                           // the lever squared [m]
  double noise = 0;        // tremor, force rms around 10 Hz, each axis [N]
  std::uint64_t seed = 1;  // of the tremor
};

// The grips of section "grip" by name: "off", "light", "firm".
inline constexpr HandModel kHandsOff{0, 0.5, 20};
inline constexpr HandModel kLightGrip{0.15, 3, 100};
inline constexpr HandModel kFirmGrip{0.5, 10, 500};

// Keyframes are offsets from the home pose: displacement in world axes [m], rotation in world axes about the handle.
struct HandScript {
  HandModel hand;
  std::vector<Keyframe> keyframes;
  Interpolation interpolation = Interpolation::minimum_jerk;
  bool loop = false;
};

// Throws ConfigError with every fault of the file, file:line each.
HandScript read_hand_script(const std::string& path);

// Returns the file that a name stands for: a path, or the bare name of one of palp's own hands, with or without .toml.
// Throws ConfigError that names those there are.
std::string find_hand_file(const std::string& name);

}  // namespace palp
