// A server for the tests: a proxy that a spring wall stops, or free space, with the delays, losses and lies that the
// test asks for. It knows the messages and restates the coupling law; it shares no code with the bridge.
#pragma once

#include <cmath>
#include <cstdint>
#include <deque>

#include "haptic_bridge/device/grip.h"
#include "haptic_bridge/loop/force_limits.h"
#include "haptic_bridge/loop/haptic_device.h"
#include "haptic_bridge/loop/loop.h"

namespace palp::test {

inline constexpr std::uint64_t kBridgeSession = 77;
inline constexpr std::int64_t kMillisecond = 1'000'000;

// A pose that the test sets by hand, and the wrenches that came back.
class PuppetDevice final : public HapticDevice {
 public:
  const DeviceInfo& info() const noexcept override { return about; }
  bool read(std::int64_t now_ns, DeviceReading& out) noexcept override {
    out = reading;
    out.dead_man = reading.dead_man && (!regrips || grip_.holds(now_ns));
    return readable;
  }
  bool write(const Wrench<double>& w) noexcept override {
    written = w;
    return writable;
  }
  void show(LoopState state) noexcept override {
    shown = state;
    grip_.show(state);
  }

  DeviceReading reading{
      {Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()},
      true,
      true,
      true};
  Wrench<double> written = zero_wrench();
  LoopState shown = LoopState::waiting;
  bool readable = true;
  bool writable = true;
  bool regrips = true;  // lets go and takes hold again when the loop waits for that
  DeviceInfo about{"puppet", 35, 3, true};

 private:
  Grip grip_;
};

// A sample that the bridge must take: answers a device state with a wrench.
inline ProxySample answer(const DeviceSample& device, std::uint64_t session, std::uint64_t sequence) {
  ProxySample s;
  s.header.session = session;
  s.header.sequence = sequence;
  s.device = device.device;
  s.flags = kEngaged | kHealthy;
  s.sim_time = 1e-3 * static_cast<double>(sequence);
  s.device_session = kBridgeSession;
  s.device_sequence = sequence;
  s.t_device_ns = device.t_device_ns;
  s.device_pose = device.pose;
  s.device_twist = device.twist;
  s.proxy_pose = device.pose;
  s.gains = device.gains;
  return s;
}

// The proxy of a tool of little mass at a wall z = height that only pushes: it rests where the wall's spring and the
// coupling's balance, so the wrench is that of both springs in series, and the local stiffness is known exactly.
struct SpringWall {
  double stiffness = 5000;  // [N/m]
  double height = 0;        // [m]

  void touch(ProxySample& s) const {
    const double k = s.gains.stiffness, depth = height - s.device_pose.position[2];
    if (depth <= 0) return;
    const double share = stiffness / (k + stiffness);
    s.blend = {share, 0};
    s.proxy_pose.position[2] = s.device_pose.position[2] + share * depth;
    s.wrench.force[2] = k * share * depth - s.gains.damping * share * s.device_twist.linear[2];
  }
};

}  // namespace palp::test
