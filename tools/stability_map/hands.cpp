#include "tools/stability_map/hands.h"

#include <cmath>
#include <limits>
#include <random>

namespace palp::stability {
namespace {

using Eigen::Vector3d;

// Returns a vector of [-1, 1]^3 that depends on nothing but the number.
Vector3d scattered(int number) {
  std::mt19937 random(static_cast<unsigned>(number));
  const auto next = [&] { return 2 * static_cast<double>(random()) / 4294967295.0 - 1; };
  return {next(), next(), next()};
}

}  // namespace

HandPath::HandPath(const Setup& setup, const Scene& scene) : setup_(setup) {
  if (scene.proxies.empty()) return;
  const Proxy& proxy = scene.proxies.front();
  const Body& tool = scene.bodies[proxy.body];
  any_ = true;
  gains_ = proxy.limit;
  start_.position = tool.position + tool.orientation * proxy.handle;
  start_.orientation = tool.orientation;
}

StepInput HandPath::at(int k) const {
  StepInput input{};
  if (!any_) return input;
  DeviceInput& in = input.front();
  in.engaged = true;
  in.gains = gains_;
  in.state = start_;
  const double t = k / setup_.rate, v = setup_.speed, dx = setup_.spacing;
  Vector3d& x = in.state.position;
  Vector3d& u = in.state.linear;
  switch (setup_.hand) {
    case Hand::none:
    case Hand::still:
      break;
    case Hand::press:  // down, through what is there and on
      u = {0, 0, -v};
      x += t * u;
      break;
    case Hand::stir: {  // in a circle of three spacings, as deep
      const double r = 3 * dx, turn = v / r * t;
      x += Vector3d(r * (std::cos(turn) - 1), r * std::sin(turn), -std::min(3 * dx, v * t));
      u = {-v * std::sin(turn), v * std::cos(turn), v * t < 3 * dx ? -v : 0};
      break;
    }
    case Hand::shake: {  // up and down by eight spacings, evenly
      const double length = 8 * dx, way = std::fmod(v * t, 2 * length);
      const bool down = way < length;
      x.z() -= down ? way : 2 * length - way;
      u.z() = down ? -v : v;
      break;
    }
    case Hand::pass: {  // across by twenty spacings and through the middle of what is there, then at rest
      const Vector3d way(20 * dx, 0, 0);
      const double share = v * t / way.norm();
      x += Vector3d(-10 * dx, 0, -3 * dx) + std::min(1.0, share) * way;
      if (share < 1) u = {v, 0, 0};
      break;
    }
    case Hand::teleport:  // by up to a metre, without a twist that tells of it
      x += scattered(k / 10);
      break;
    case Hand::spin:
      in.state.angular = {0, 0, v / dx};
      in.state.orientation = Eigen::AngleAxisd(v / dx * t, Vector3d::UnitZ()) * start_.orientation;
      x.z() -= std::min(3 * dx, 0.1 * t);
      break;
    case Hand::wild:  // another place and another twist at each step
      x += 5 * dx * scattered(2 * k);
      u = v * scattered(2 * k + 1);
      in.state.angular = v / dx * scattered(3 * k + 2);
      break;
    case Hand::nonsense:
      if (k % 7 == 3) x.x() = std::numeric_limits<double>::quiet_NaN();
      if (k % 7 == 4) u.z() = std::numeric_limits<double>::infinity();
      if (k % 7 == 5) in.state.orientation.coeffs().setZero();
      if (k % 7 == 6) in.gains.damping = -1e30;
      break;
  }
  return input;
}

}  // namespace palp::stability
