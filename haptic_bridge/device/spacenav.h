// A 3D mouse through libspnav, the client of the spacenav daemon: pushing its cap moves the handle at a speed. The hand
// feels no force, so the force holds the handle back instead: at the largest force it stands still however hard the cap
// is pushed. The library is opened when it is asked for.
#pragma once

#include <memory>
#include <string>

#include "haptic_bridge/device/driver.h"
#include "haptic_bridge/device/grip.h"
#include "haptic_bridge/loop/haptic_device.h"

namespace palp {

struct SpacenavSetup {
  std::string library = "libspnav.so.0";
  double speed = 0.2;  // of the handle with the cap pushed fully [m/s]
  double turn = 1.0;   // [rad/s]
};

class SpacenavDevice final : public HapticDevice {
 public:
  // start: where the handle is at first, world frame. Throws ConfigError when there is no such library,
  // std::runtime_error when no daemon answers.
  SpacenavDevice(const SpacenavSetup& setup, const RigidState& start);
  ~SpacenavDevice() override;
  // Throws what opening would throw now.
  static void check(const SpacenavSetup& setup);

  const DeviceInfo& info() const noexcept override { return info_; }
  // Takes the daemon's events, which never waits. False once the daemon has gone. No allocation.
  bool read(std::int64_t now_ns, DeviceReading& out) noexcept override;
  bool write(const Wrench<double>& wrench) noexcept override;
  void show(LoopState state) noexcept override { grip_.show(state); }
  std::string trouble() const override;

 private:
  struct Library;
  void take_events() noexcept;
  void move(double dt) noexcept;

  SpacenavSetup setup_;
  std::unique_ptr<Library> library_;
  DeviceInfo info_;
  Grip grip_;
  RigidState state_;
  Eigen::Vector3d push_ = Eigen::Vector3d::Zero(), twist_ = Eigen::Vector3d::Zero();  // of the cap, world, -1..1
  Wrench<double> felt_;
  std::uint32_t buttons_ = 0;
  bool started_ = false, gone_ = false;
  std::int64_t t_last_ns_ = 0;
};

// Its setup is a SpacenavSetup (table [spacenav] of a profile).
Driver spacenav_driver();

}  // namespace palp
