// A device as the simulation may trust it: the newest sample of one device, aged, bounded and eased in.
#pragma once

#include "idl/messages.h"
#include "sim_server/simulation.h"

namespace palp {

// A hand that has been silent this long has let go: its proxy stops where it is.
inline constexpr double kSilentAfter = 0.05;  // [s]
// The coupling of a hand that has just taken hold grows over this time.
inline constexpr double kEaseIn = 0.3;  // [s]
// No hand moves faster; a device that says so is cut to this.
inline constexpr double kFastestHand = 5.0;   // [m/s]
inline constexpr double kFastestTurn = 30.0;  // [rad/s]
// The coupling never pulls harder than this, however far the device has jumped.
inline constexpr double kStrongestPull = 100.0;  // [N]

class Hand {
 public:
  void receive(const DeviceSample& sample, std::int64_t t_receive_ns);
  // What the simulation gets for its next step, moved on to now. proxy: where the handle is.
  DeviceInput input(std::int64_t now_ns, double step, const RigidState& proxy);
  const DeviceSample& sample() const { return sample_; }
  bool engaged() const { return held_for_ > 0; }

 private:
  DeviceSample sample_;
  std::int64_t t_receive_ns_ = 0;
  bool known_ = false;
  double held_for_ = 0;  // [s] since the hand took hold
};

}  // namespace palp
