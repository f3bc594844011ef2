#include "haptic_bridge/preparation.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "config/data_dir.h"
#include "config/error.h"

namespace palp {

namespace {

constexpr double kSelfTest = 5;           // before a device with motors is used [s]
constexpr double kUntrustedForce = 3;     // sent on a machine that is often late [N]
constexpr double kUntrustedTorque = 0.2;  // [N m]

}  // namespace

std::size_t logged_ticks(const BridgeOptions& o) { return static_cast<std::size_t>(o.log_seconds * o.rate_hz); }

DeviceRequest make_request(const BridgeOptions& o) {
  const bool by_name = !o.profile.empty() && !std::filesystem::exists(o.profile);
  const std::string file = by_name ? find_data_file(kDeviceProfiles, o.profile) : o.profile;
  DeviceRequest request{file.empty() ? DeviceProfile{} : read_device_profile(file), file, o.driver_options};
  LoopConfig& loop = request.profile.loop;
  loop.gains.stiffness = o.stiffness.value_or(loop.gains.stiffness);
  loop.gains.damping = o.damping.value_or(loop.gains.damping);
  loop.gains.angular_stiffness = o.angular_stiffness.value_or(loop.gains.angular_stiffness);
  loop.gains.angular_damping = o.angular_damping.value_or(loop.gains.angular_damping);
  loop.workspace.motion_scale = o.motion_scale.value_or(loop.workspace.motion_scale);
  loop.workspace.force_scale = o.force_scale.value_or(loop.workspace.force_scale);
  loop.period_ns = std::llround(1e9 / o.rate_hz);
  loop.device = o.device_number;
  // a device without motors harms nobody when this machine is busy
  if (o.profile.empty() && !o.driver->has_motors()) loop.safety.overrun_ns = loop.safety.late_ticks = 0;
  if (o.driver->prepare) o.driver->prepare(request);
  return request;
}

std::unique_ptr<LogRoom> room_for_files(const BridgeOptions& o) {
  std::unique_ptr<LogRoom> room;
  try {
    room = std::make_unique<LogRoom>(o.log, logged_ticks(o));
  } catch (const std::exception& error) {
    throw ConfigError(error.what());
  }
  std::error_code ignored;
  const bool was_there = std::filesystem::exists(o.summary, ignored);
  if (!std::ofstream(o.summary, std::ios::app))
    throw ConfigError(fmt::format("summary {}: it cannot be written; give another file with --summary", o.summary));
  if (!was_there) std::filesystem::remove(o.summary, ignored);
  return room;
}

std::unique_ptr<Supervisor> supervise(const BridgeOptions& o, const DeviceRequest& request, const SharedLog& shared) {
  std::function<void()> off;
  if (o.driver->has_motors()) off = [&request, power_off = o.driver->power_off] { power_off(request); };
  return std::make_unique<Supervisor>(off, [&shared, path = o.log]() -> std::string {
    if (shared.log.is_written()) return "the flight log is in " + path;
    if (shared.log.size() == 0) return "there is no flight log, for no tick was done";
    write_log_and_run(shared.log, shared.config[0], path);
    return fmt::format("the flight log was written to {} ({} ticks)", path, shared.log.size());
  });
}

std::string test_machine(const BridgeOptions& o, LoopConfig& config) {
  const double seconds = o.self_test.value_or(o.driver->has_motors() ? kSelfTest : 0);
  if (seconds <= 0) return "lateness not tested";
  const Lateness l = measure_lateness(o.realtime, config.period_ns, seconds);
  const bool trusted = l.p999_us <= kTrustedLateness;
  if (!trusted && !o.full_force) {
    config.limits.force = std::min(config.limits.force, kUntrustedForce);
    config.limits.torque = std::min(config.limits.torque, kUntrustedTorque);
  }
  return fmt::format("late in {:.0f} s of test by {:.0f} us (median), {:.0f} us (99.9 %), {:.0f} us (worst): {}",
                     l.seconds, l.p50_us, l.p999_us, l.max_us,
                     trusted        ? "full force"
                     : o.full_force ? "too late for an arm, full force all the same"
                                    : fmt::format("too late for an arm, at most {} N and {} N m", config.limits.force,
                                                  config.limits.torque));
}

}  // namespace palp
