// A device that plays a recorded pose path from a file and feels nothing.
#pragma once

#include <string>

#include "haptic_bridge/device/driver.h"
#include "haptic_bridge/device/grip.h"
#include "haptic_bridge/device/trajectory.h"
#include "haptic_bridge/loop/haptic_device.h"

namespace palp {

class ReplayDevice final : public HapticDevice {
 public:
  // A pose path (config/pose_path.h) that turns by less than 143 degrees from pose to pose. It begins at the first read
  // and is joined by a smooth curve; then it holds its last pose, or (loop) begins again, for which it must end where
  // it began. Throws ConfigError naming the file.
  ReplayDevice(const std::string& file, bool loop);

  const DeviceInfo& info() const noexcept override { return info_; }
  bool read(std::int64_t now_ns, DeviceReading& out) noexcept override;
  bool write(const Wrench<double>&) noexcept override { return true; }
  void show(LoopState state) noexcept override { grip_.show(state); }

 private:
  Grip grip_;
  Trajectory path_;
  DeviceInfo info_;
  bool started_ = false;
  std::int64_t t_start_ns_ = 0;
};

Driver replay_driver();

}  // namespace palp
