// A film's camera, as a script in TOML has it (config/films/README.md): poses at simulated times, joined smoothly, a
// tool that it may follow, and captions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "viewer/home_view.h"

namespace palp {

struct CameraKey {
  double time = 0;  // [s] simulated
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();
  Eigen::Vector3d look_at = Eigen::Vector3d::Zero();
  double field_of_view = kFieldOfView;  // vertical [degrees]
};

struct Caption {
  double from = 0, to = 0;  // [s] simulated
  std::string text;
};

// The camera goes with a tool: by this share of the way that its handle has gone since the start.
struct CameraFollow {
  std::uint32_t device = 0;
  double share = 1;     // 0 .. 1
  double smooth = 0.5;  // [s], over which the way is averaged, half of it before the time shown and half of it after
};

struct CameraScript {
  std::vector<CameraKey> keys;  // at least one, by time
  std::optional<CameraFollow> follow;
  std::vector<Caption> captions;
};

// Throws ConfigError with every fault of the file, file:line each.
CameraScript read_camera_script(const std::string& file);
CameraScript parse_camera_script(const std::string& text, const std::string& file);

// Returns the camera at a time: through every key, at rest at the first and the last one, without a jump in speed, and
// no number of it ever outside of those of the two keys beside it (monotone cubics: Fritsch & Carlson 1980, with the
// slopes of Fritsch & Butland 1984). Before the first key and after the last it stands.
CameraKey camera_at(const std::vector<CameraKey>& keys, double time);

// Returns the words of the caption at that time and how opaque they are, 0 .. 1: they fade in and out within 0.3 s.
struct ShownCaption {
  std::string text;
  double opacity = 0;
};
ShownCaption caption_at(const std::vector<Caption>& captions, double time);

}  // namespace palp
