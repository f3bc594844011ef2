#include <algorithm>
#include <cmath>

#include "tools/run_scene.h"

namespace palp {

DeviceInput device_on_path(const std::vector<PathPose>& path, double time, const CouplingGains& gains) {
  DeviceInput input;
  input.gains = gains;
  input.engaged = time >= path.front().time;
  const auto next =
      std::upper_bound(path.begin(), path.end(), time, [](double t, const PathPose& pose) { return t < pose.time; });
  const bool moving = next != path.begin() && next != path.end();
  const PathPose& a = next == path.begin() ? path.front() : *(next - 1);
  input.state.position = a.position;
  input.state.orientation = a.orientation;
  if (!moving) return input;
  const PathPose& b = *next;
  const double span = b.time - a.time, part = (time - a.time) / span;
  input.state.position = a.position + part * (b.position - a.position);
  input.state.orientation = a.orientation.slerp(part, b.orientation);
  input.state.linear = (b.position - a.position) / span;
  Eigen::Quaterniond turn = b.orientation * a.orientation.conjugate();
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const Eigen::AngleAxisd rotation(turn);
  input.state.angular = rotation.axis() * (rotation.angle() / span);
  return input;
}

double repeated(const std::vector<PathPose>& path, double time) {
  const double begin = path.front().time, period = path.back().time - begin;
  return time <= begin || !(period > 0) ? time : begin + std::fmod(time - begin, period);
}

}  // namespace palp
