// The simulated hands that every metric is measured with, and what they do.
#pragma once

#include <string>
#include <vector>

#include "haptic_bridge/device/hand_script.h"

namespace palp::bench {

struct NamedHand {
  std::string name;
  HandModel model;
};
// "off": a hand that hardly holds on; "light" and "firm": grips of a few newtons.
const std::vector<NamedHand>& hands();
const NamedHand& hand_named(const std::string& name);  // throws std::invalid_argument

// Stays where it starts, then goes along `by` within `during` [s] and remains there.
HandScript push(const HandModel& hand, double wait, double during, const Eigen::Vector3d& by);
// Sine along `amplitude` around `center`, from there, for a whole number of periods. The first period eases in.
HandScript swing(const HandModel& hand, const Eigen::Vector3d& center, const Eigen::Vector3d& amplitude, double hz,
                 double seconds);
// The same script with rotations in place of the ways: a metre becomes a radian.
HandScript turned(HandScript script);
// The same script after a rest of `wait` [s] at the start.
HandScript delayed(HandScript script, double wait);

}  // namespace palp::bench
