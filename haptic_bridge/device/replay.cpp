#include "haptic_bridge/device/replay.h"

#include <charconv>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "config/error.h"
#include "config/text_file.h"
#include "haptic_bridge/loop/filters.h"

namespace palp {

namespace {

constexpr const char* kHeader = "time,x,y,z,qx,qy,qz,qw";
constexpr std::size_t kMaxLines = 10'000'000;
constexpr std::size_t kMaxBytes = std::size_t{1} << 31;

// The eight numbers of a line; a fault is thrown as ConfigError.
std::array<double, 8> parse_line(const std::string& line, const std::string& where) {
  std::array<double, 8> values{};
  const char* at = line.data();
  const char* const end = at + line.size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto [stop, error] = std::from_chars(at, end, values[i]);
    const bool last = i + 1 == values.size();
    if (error != std::errc() || (last ? stop != end : (stop == end || *stop != ',')))
      throw ConfigError(where + ": column " + std::to_string(i + 1) +
                        " is not a number, or the line has not exactly 8 "
                        "columns (" +
                        kHeader + ")");
    if (!std::isfinite(values[i])) throw ConfigError(where + ": column " + std::to_string(i + 1) + " is not finite");
    at = stop + 1;
  }
  return values;
}

Trajectory make_path(const std::string& file, bool loop) {
  std::vector<Keyframe> path = read_pose_path(file);
  try {
    return Trajectory(std::move(path), Interpolation::catmull_rom, loop);
  } catch (const std::invalid_argument& e) {
    throw ConfigError(file + ": " + e.what());
  }
}

}  // namespace

std::vector<Keyframe> read_pose_path(const std::string& file) {
  std::istringstream in(read_text_file(file, kMaxBytes));
  std::vector<Keyframe> path;
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    const std::string where = file + ":" + std::to_string(number);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (number == 1) {
      if (line != kHeader)
        throw ConfigError(where + ": the first line must be \"" + kHeader + "\" (s, m, unit quaternion)");
      continue;
    }
    if (number > kMaxLines) throw ConfigError(where + ": more than ten million lines");
    const auto c = parse_line(line, where);
    const Keyframe k{c[0], {c[1], c[2], c[3]}, {c[7], c[4], c[5], c[6]}};
    if (!is_unit(k.q)) throw ConfigError(where + ": the quaternion's length must be 1 within 0.001");
    if (!path.empty() && k.time <= path.back().time)
      throw ConfigError(where + ": the time must be later than that of the line before");
    if (!path.empty() && rotation_between(path.back().q, k.q.normalized()).norm() >= kMaxCouplingAngle)
      throw ConfigError(where + ": it turns by more than 143 degrees from the line before");
    path.push_back(k);
    path.back().q.normalize();
  }
  if (path.empty())
    throw ConfigError(file + ": no poses; expected the line \"" + std::string(kHeader) + "\" and then poses");
  return path;
}

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
