#include "haptic_bridge/device/replay.h"

#include <stdexcept>

#include "config/error.h"
#include "config/pose_path.h"
#include "haptic_bridge/loop/force_limits.h"

namespace palp {

namespace {

Trajectory make_path(const std::string& file, bool loop) {
  std::vector<Keyframe> path;
  for (const PathPose& pose : read_pose_path(file)) {
    if (!path.empty() && rotation_between(path.back().q, pose.orientation).norm() >= kMaxCouplingAngle)
      throw ConfigError(file + ":" + std::to_string(pose.line) +
                        ": it turns by more than 143 degrees from the row before");
    path.push_back({pose.time, pose.position, pose.orientation});
  }
  try {
    return Trajectory(std::move(path), Interpolation::catmull_rom, loop);
  } catch (const std::invalid_argument& e) {
    throw ConfigError(file + ": " + e.what());
  }
}

}  // namespace

ReplayDevice::ReplayDevice(const std::string& file, bool loop)
    : path_(make_path(file, loop)), info_{"replay of " + file, 1e9, 1e9, false} {}

bool ReplayDevice::read(std::int64_t now_ns, DeviceReading& out) noexcept {
  if (!started_) t_start_ns_ = now_ns;
  started_ = true;
  out.state = path_.at(path_.keyframes().front().time + 1e-9 * static_cast<double>(now_ns - t_start_ns_));
  out.dead_man = grip_.holds(now_ns);
  out.powered = out.chain_closed = true;
  out.buttons = 0;
  return true;
}

Driver replay_driver() {
  return {.name = "replay",
          .what = "a recorded path",
          .needs = "",
          .options = {{"--path", "FILE", "CSV of time,x,y,z,qx,qy,qz,qw in s and m, world frame"},
                      {"--loop-path", nullptr, "begin again at the end (the path must end where it began)"}},
          .starts_in_scene = false,
          .read_profile = nullptr,
          .prepare =
              [](DeviceRequest& request) {
                if (request.option("--path").empty())
                  throw ConfigError("--device replay needs --path FILE, the path to replay");
              },
          .open = [](const DeviceRequest& request, const HandleStart&) -> std::unique_ptr<HapticDevice> {
            return std::make_unique<ReplayDevice>(request.option("--path"), request.options.contains("--loop-path"));
          },
          .power_off = nullptr};
}

}  // namespace palp
