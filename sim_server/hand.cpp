#include "sim_server/hand.h"

#include <algorithm>

#include "sim_server/to_messages.h"

namespace palp {
namespace {

Eigen::Vector3d cut(const Eigen::Vector3d& v, double most) {
  const double n = v.norm();
  return n > most ? Eigen::Vector3d(v * (most / n)) : v;
}

Eigen::Quaterniond turned(const Eigen::Quaterniond& q, const Eigen::Vector3d& by) {
  const double angle = by.norm();
  return angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, by / angle)) * q : q;
}

}  // namespace

void Hand::receive(const DeviceSample& sample, std::int64_t t_receive_ns) {
  // within one session only newer samples count; another session is a bridge that was started again
  if (known_ && sample.header.session == sample_.header.session && sample.header.sequence <= sample_.header.sequence)
    return;
  sample_ = sample;
  t_receive_ns_ = t_receive_ns;
  silent_for_ = 0;
  known_ = true;
}

DeviceInput Hand::input(std::int64_t now_ns, double step, const RigidState& proxy) {
  DeviceInput in;
  silent_for_ += step;
  if (!known_ || !(sample_.flags & kEngaged) || silent_for_ > kSilentAfter + step / 2) {
    held_for_ = 0;
    return in;
  }
  held_for_ += step;
  const double ease = std::min(1.0, held_for_ / kEaseIn);
  in.engaged = true;
  in.state = to_rigid_state(sample_.pose, sample_.twist);
  in.state.linear = cut(in.state.linear, kFastestHand);
  in.state.angular = cut(in.state.angular, kFastestTurn);
  // lost and late samples: the hand has moved on meanwhile
  const double ahead = std::clamp(1e-9 * static_cast<double>(now_ns - t_receive_ns_), 0.0, kMostAhead);
  in.state.position += ahead * in.state.linear;
  in.state.orientation = turned(in.state.orientation, ahead * in.state.angular);
  in.gains = {ease * sample_.gains.stiffness, sample_.gains.damping, ease * sample_.gains.angular_stiffness,
              sample_.gains.angular_damping};
  if (in.gains.stiffness > 0)
    in.state.position = proxy.position + cut(in.state.position - proxy.position, kStrongestPull / in.gains.stiffness);
  return in;
}

}  // namespace palp
