#include "viewer/frame_blend.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "idl/convert.h"

namespace palp {
namespace {

constexpr double kFastest = 20;  // [m/s]; what is faster has been put elsewhere

// Returns how far sim_time is from a to b, 0 .. 1.
double share_of(double a, double b, double sim_time) {
  return b > a ? std::clamp((sim_time - a) / (b - a), 0.0, 1.0) : 0;
}

}  // namespace

ParticleFrame between(const ParticleFrame& a, const ParticleFrame& b, double sim_time) {
  ParticleFrame out = a;
  const auto share = static_cast<float>(share_of(a.sim_time, b.sim_time, sim_time));
  out.sim_time = sim_time;
  if (share == 0 || a.positions.size() != b.positions.size()) return out;
  const double reach = kFastest * (b.sim_time - a.sim_time);
  const auto farthest = static_cast<float>(reach * reach);
  for (std::size_t i = 0; i + 2 < out.positions.size(); i += 3) {
    float* p = &out.positions[i];
    const float* q = &b.positions[i];
    const float x = q[0] - p[0], y = q[1] - p[1], z = q[2] - p[2];
    if (!(x * x + y * y + z * z <= farthest)) continue;
    p[0] += share * x;
    p[1] += share * y;
    p[2] += share * z;
  }
  if (a.solid.size() == b.solid.size()) {
    for (std::size_t i = 0; i < out.solid.size(); ++i)
      out.solid[i] = static_cast<std::uint8_t>(std::lround(std::lerp(float(a.solid[i]), float(b.solid[i]), share)));
  }
  if (a.field != b.field || a.scalars.size() != b.scalars.size()) return out;
  for (std::size_t i = 0; i < out.scalars.size(); ++i) out.scalars[i] += share * (b.scalars[i] - out.scalars[i]);
  return out;
}

BodyPoses between(const BodyPoses& a, const BodyPoses& b, double sim_time) {
  BodyPoses out = a;
  const double share = share_of(a.sim_time, b.sim_time, sim_time);
  out.sim_time = sim_time;
  for (std::size_t i = 0; i < out.body.size() && i < out.pose.size(); ++i) {
    // bodies come in the same order in all samples of a run
    const bool same = i < b.body.size() && i < b.pose.size() && b.body[i] == out.body[i];
    if (!same || share == 0) continue;
    const Eigen::Vector3d from = to_vector(a.pose[i].position), to = to_vector(b.pose[i].position);
    const Eigen::Quaterniond q = to_quaternion(a.pose[i].orientation).normalized(),
                             r = to_quaternion(b.pose[i].orientation).normalized();
    if ((to - from).norm() > kFastest * (b.sim_time - a.sim_time)) continue;
    out.pose[i] = to_pose(at_rest(from + share * (to - from), q.slerp(share, r)));
  }
  return out;
}

}  // namespace palp
