#include "config/pose_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "config/error.h"
#include "config/text_file.h"

namespace palp {

namespace {

constexpr std::size_t kMaxPathBytes = std::size_t{1} << 30;
constexpr std::string_view kHeader = "time,x,y,z,qx,qy,qz,qw";

PathPose read_row(std::string_view line, const std::string& where) {
  std::array<double, 8> value{};
  for (std::size_t cell = 0; cell < 8; ++cell) {
    const std::size_t comma = line.find(',');
    if ((comma == std::string_view::npos) != (cell == 7)) {
      throw ConfigError(fmt::format("{}: expected 8 cells: {}", where, kHeader));
    }
    const auto number = parse_number(line.substr(0, comma));
    if (!number || std::abs(*number) > 1e9) {
      throw ConfigError(fmt::format("{}: '{}' is no number from -1e9 to 1e9", where,
                                    line.substr(0, std::min<std::size_t>(comma, 40))));
    }
    value[cell] = *number;
    if (cell < 7) line.remove_prefix(comma + 1);
  }
  PathPose pose{value[0], {value[1], value[2], value[3]}, {value[7], value[4], value[5], value[6]}, 0};
  if (std::abs(pose.orientation.norm() - 1) > 1e-3) {
    throw ConfigError(fmt::format("{}: the quaternion has length {:g}, expected 1", where, pose.orientation.norm()));
  }
  pose.orientation.normalize();
  return pose;
}

}  // namespace

std::vector<PathPose> read_pose_path(const std::string& file) {
  const std::string bytes = read_text_file(file, kMaxPathBytes);
  std::string_view text = bytes;
  std::vector<PathPose> path;
  bool header = false;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.find_first_not_of(" \t") == std::string_view::npos || line[0] == '#') continue;
    const std::string where = fmt::format("{}:{}", file, number);
    if (!header) {
      if (line != kHeader)
        throw ConfigError(fmt::format("{}: the header is '{}', expected {}", where, line.substr(0, 80), kHeader));
      header = true;
      continue;
    }
    path.push_back(read_row(line, where));
    path.back().line = number;
    if (path.size() > 1 && !(path.back().time > path[path.size() - 2].time)) {
      throw ConfigError(
          fmt::format("{}: time is {:g}, expected more than that of the row before", where, path.back().time));
    }
  }
  if (path.empty())
    throw ConfigError(fmt::format("{}: no poses, expected a header {} and rows of numbers", file, kHeader));
  return path;
}

}  // namespace palp
