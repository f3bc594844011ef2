#include "tools/haptic_bench/hands.h"

#include <cmath>
#include <stdexcept>

#include "idl/coupling.h"

namespace palp::bench {

const std::vector<NamedHand>& hands() {
  static const std::vector<NamedHand> kHands{{"off", kHandsOff}, {"light", kLightGrip}, {"firm", kFirmGrip}};
  return kHands;
}

const NamedHand& hand_named(const std::string& name) {
  for (const NamedHand& h : hands())
    if (h.name == name) return h;
  throw std::invalid_argument("there is no hand '" + name + "': expected off, light or firm");
}

HandScript push(const HandModel& hand, double wait, double during, const Eigen::Vector3d& by) {
  HandScript script;
  script.hand = hand;
  script.keyframes = {{0, Eigen::Vector3d::Zero()}, {wait, Eigen::Vector3d::Zero()}, {wait + during, by}};
  return script;
}

HandScript swing(const HandModel& hand, const Eigen::Vector3d& center, const Eigen::Vector3d& amplitude, double hz,
                 double seconds) {
  HandScript script;
  script.hand = hand;
  script.interpolation = Interpolation::catmull_rom;
  constexpr int kKeys = 24;  // a period
  const int count = static_cast<int>(std::lround(seconds * hz)) * kKeys;
  for (int k = 0; k <= count; ++k) {
    const double ease = std::min(1.0, static_cast<double>(k) / kKeys);
    script.keyframes.push_back({k / (kKeys * hz), center + ease * std::sin(2 * M_PI * k / kKeys) * amplitude});
  }
  return script;
}

HandScript turned(HandScript script) {
  for (Keyframe& k : script.keyframes) {
    k.q = rotation_by(k.x);
    k.x.setZero();
  }
  return script;
}

HandScript delayed(HandScript script, double wait) {
  for (Keyframe& k : script.keyframes) k.time += wait;
  script.keyframes.insert(script.keyframes.begin(), Keyframe{});
  return script;
}

}  // namespace palp::bench
