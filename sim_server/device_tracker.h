// A device as the simulation may trust it: the newest sample of one device, aged, bounded and eased in.
#pragma once

#include "idl/messages.h"
#include "sim_server/solver/simulation.h"

namespace palp {

// A hand that has been silent this long has let go: its proxy stops where it is. Of simulated time, so that the same
// samples before the same steps give the same motion, however fast the server runs.
inline constexpr double kSilentAfter = 0.05;  // [s]
// After this much silence a session may begin its numbers anew: links do not hold samples back that long.
inline constexpr double kBeginsAnewAfter = 0.2;  // [s]
// A hand is taken to move on with its twist for this long after its newest sample came. From then on it slows down,
// with the time constant below: a hand that stopped at once, only because nothing was heard of it, would have its tool
// stopped and thrown after it again, and one that went on might have turned round.
inline constexpr double kMostAhead = 0.006;  // [s]
inline constexpr double kSlowsDown = 0.04;   // [s]
// The coupling of a hand that has just taken hold grows over this time.
inline constexpr double kEaseIn = 0.3;  // [s]
// No hand moves faster; a device that says so is cut to this.
inline constexpr double kFastestHand = 5.0;   // [m/s]
inline constexpr double kFastestTurn = 30.0;  // [rad/s]
// The coupling never pulls harder than this, however far the device has jumped.
inline constexpr double kStrongestPull = 100.0;  // [N]

class DeviceTracker {
 public:
  void receive(const DeviceSample& sample, std::int64_t t_receive_ns);
  // Returns what the simulation gets for its next step: the newest sample, moved on with its twist for as long as it
  // has waited here, by the receiver's own clock. How long it was on its way is not known: the clocks of two hosts
  // differ. proxy: where the handle is.
  DeviceInput input(std::int64_t now_ns, double step, const RigidState& proxy);
  const DeviceSample& sample() const { return sample_; }
  bool engaged() const { return held_for_ > 0; }

 private:
  DeviceSample sample_;
  std::int64_t t_receive_ns_ = 0;
  bool known_ = false;
  double silent_for_ = 0;  // [s] of steps since the newest sample
  double held_for_ = 0;    // [s] since the hand took hold
};

}  // namespace palp
