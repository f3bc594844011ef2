#include "sim_server/device_tracker.h"

#include <algorithm>
#include <cmath>

#include "idl/convert.h"
#include "sim_server/solver/rigid_motion.h"

namespace palp {

void DeviceTracker::receive(const DeviceSample& sample, std::int64_t t_receive_ns) {
  const bool same = known_ && sample.header.session == sample_.header.session;
  // within one session only newer samples count, but after silence: a recording of it is replayed from its beginning
  if (same && sample.header.sequence <= sample_.header.sequence && silent_for_ < kBeginsAnewAfter) return;
  // whose hand it is now has not held the tool before
  if (!same) held_for_ = 0;
  sample_ = sample;
  t_receive_ns_ = t_receive_ns;
  silent_for_ = 0;
  known_ = true;
}

DeviceInput DeviceTracker::input(std::int64_t now_ns, double step, const RigidState& proxy) {
  DeviceInput in;
  silent_for_ += step;
  if (!known_ || !(sample_.flags & kEngaged) || silent_for_ > kSilentAfter + step / 2) {
    held_for_ = 0;
    return in;
  }
  held_for_ += step;
  const double ease = std::min(1.0, held_for_ / kEaseIn);
  in.engaged = true;
  in.state = to_state(sample_.pose, sample_.twist);
  in.state.linear = clamp_norm(in.state.linear, kFastestHand);
  in.state.angular = clamp_norm(in.state.angular, kFastestTurn);
  // lost and late samples: the hand has moved on meanwhile. Counted in steps, too, so that no clock that jumps moves it
  // far.
  const double waited = std::max(0.0, 1e-9 * static_cast<double>(now_ns - t_receive_ns_));
  const double sure = std::min(waited, kMostAhead), past = std::min(waited - sure, silent_for_);
  const double left = std::exp(-past / kSlowsDown);
  in.state = extrapolate(in.state, sure + kSlowsDown * (1 - left));
  in.state.linear *= left;
  in.state.angular *= left;
  in.gains = {ease * sample_.gains.stiffness, sample_.gains.damping, ease * sample_.gains.angular_stiffness,
              sample_.gains.angular_damping};
  if (in.gains.stiffness > 0)
    in.state.position =
        proxy.position + clamp_norm(in.state.position - proxy.position, kStrongestPull / in.gains.stiffness);
  return in;
}

}  // namespace palp
