#include "haptic_bridge/device/trajectory.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "idl/coupling.h"

namespace palp {

namespace {

using Vec3 = Eigen::Vector3d;

// Angular velocity of exp(r) when r changes with rate dr: the left Jacobian of the rotation group.
Vec3 angular_velocity(const Vec3& r, const Vec3& dr) {
  const double a = r.norm(), a2 = a * a;
  const double c1 = a < 1e-4 ? 0.5 - a2 / 24 : (1 - std::cos(a)) / a2;
  const double c2 = a < 1e-4 ? 1.0 / 6 - a2 / 120 : (a - std::sin(a)) / (a2 * a);
  return dr + c1 * r.cross(dr) + c2 * r.cross(r.cross(dr));
}

// Its inverse: the rate of r that gives the angular velocity w.
Vec3 rotation_rate(const Vec3& r, const Vec3& w) {
  const double a = r.norm(), a2 = a * a;
  const double c = a < 1e-4 ? 1.0 / 12 + a2 / 720 : (1 - 0.5 * a * std::sin(a) / (1 - std::cos(a))) / a2;
  return w - 0.5 * r.cross(w) + c * r.cross(r.cross(w));
}

}  // namespace

Trajectory::Trajectory(std::vector<Keyframe> keyframes, Interpolation interpolation, bool loop)
    : keyframes_(std::move(keyframes)), loop_(loop) {
  if (keyframes_.empty()) throw std::invalid_argument("a path needs at least one keyframe");
  for (std::size_t i = 1; i < keyframes_.size(); ++i) {
    const Keyframe &a = keyframes_[i - 1], &b = keyframes_[i];
    const std::string name = "keyframe " + std::to_string(i + 1);
    if (!(b.time > a.time)) throw std::invalid_argument(name + ": its time must be later than the one before");
    if (rotation_between(a.q, b.q).norm() >= kMaxCouplingAngle)
      throw std::invalid_argument(name +
                                  ": it turns by more than 143 degrees from the one before, which leaves the way "
                                  "round open; put a keyframe between them");
  }
  const Keyframe &first = keyframes_.front(), &last = keyframes_.back();
  if (loop_ && keyframes_.size() < 2) throw std::invalid_argument("a path that loops needs at least two keyframes");
  if (loop_ && ((first.x - last.x).norm() > 1e-6 || rotation_between(first.q, last.q).norm() > 1e-5))
    throw std::invalid_argument("keyframe " + std::to_string(keyframes_.size()) +
                                ": a path that loops must end in the pose where it begins");
  if (interpolation == Interpolation::catmull_rom) find_tangents();
}

// Slope at each keyframe: that of the line between its neighbours; at the ends of an open path, rest.
void Trajectory::find_tangents() {
  const std::size_t n = keyframes_.size();
  tangents_.assign(n, {Vec3::Zero(), Vec3::Zero()});
  const auto slope = [&](std::size_t before, std::size_t after, double time) {
    return Tangent{(keyframes_[after].x - keyframes_[before].x) / time,
                   rotation_between(keyframes_[before].q, keyframes_[after].q) / time};
  };
  for (std::size_t i = 1; i + 1 < n; ++i)
    tangents_[i] = slope(i - 1, i + 1, keyframes_[i + 1].time - keyframes_[i - 1].time);
  if (loop_ && n > 2) {
    const double around = keyframes_[1].time - keyframes_[0].time + keyframes_[n - 1].time - keyframes_[n - 2].time;
    tangents_.front() = tangents_.back() = slope(n - 2, 1, around);
  }
}

RigidState Trajectory::at(double time) const noexcept {
  const Keyframe &first = keyframes_.front(), &last = keyframes_.back();
  if (loop_ && time > first.time) time = first.time + std::fmod(time - first.time, duration());
  if (time <= first.time) return {first.x, first.q, Vec3::Zero(), Vec3::Zero()};
  if (time >= last.time) return {last.x, last.q, Vec3::Zero(), Vec3::Zero()};

  const auto next = std::upper_bound(keyframes_.begin(), keyframes_.end(), time,
                                     [](double t, const Keyframe& k) { return t < k.time; });
  const Keyframe &a = *(next - 1), &b = *next;
  const double length = b.time - a.time, s = (time - a.time) / length;
  const Vec3 dx = b.x - a.x, dr = rotation_between(a.q, b.q);
  Vec3 x, v, r, rate;
  if (tangents_.empty()) {
    const double m = s * s * s * (10 + s * (-15 + 6 * s)), dm = 30 * s * s * (1 - s) * (1 - s) / length;
    x = m * dx;
    v = dm * dx;
    r = m * dr;
    rate = dm * dr;
  } else {
    // cubic Hermite from (0, slope of a) to (dx, slope of b)
    const std::size_t i = static_cast<std::size_t>(next - keyframes_.begin());
    const Tangent &ta = tangents_[i - 1], &tb = tangents_[i];
    const double h1 = s * s * (3 - 2 * s), h2 = s * (1 - s) * (1 - s), h3 = s * s * (s - 1);
    const double d1 = 6 * s * (1 - s), d2 = (1 - s) * (1 - 3 * s), d3 = s * (3 * s - 2);
    const Vec3 ra = ta.w * length, rb = rotation_rate(dr, tb.w) * length;
    x = h1 * dx + length * (h2 * ta.v + h3 * tb.v);
    v = d1 * dx / length + d2 * ta.v + d3 * tb.v;
    r = h1 * dr + h2 * ra + h3 * rb;
    rate = (d1 * dr + d2 * ra + d3 * rb) / length;
  }
  return {a.x + x, (rotation_by(r) * a.q).normalized(), v, angular_velocity(r, rate)};
}

}  // namespace palp
