#include "viewer/camera_script.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "config/toml_reader.h"

namespace palp {
namespace {

constexpr double kFade = 0.3;                  // [s] of a caption
constexpr double kSteepest = 88 * M_PI / 180;  // of the view; world z is up in the picture
constexpr Range kTimes{"s", 0, 1e6};
constexpr Range kPlaces{"m", -1e4, 1e4};

using Numbers = std::array<double, 7>;

Numbers numbers_of(const CameraKey& key) {
  return {key.eye.x(), key.eye.y(), key.eye.z(), key.look_at.x(), key.look_at.y(), key.look_at.z(), key.field_of_view};
}

// Returns the slope of a monotone curve where one with secant `before` over the time h0 meets one with `after` over h1.
double slope_between(double before, double h0, double after, double h1) {
  if (before * after <= 0) return 0;
  const double w0 = 2 * h1 + h0, w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / before + w1 / after);
}

// Returns the slopes of all numbers at key i.
Numbers slopes_at(const std::vector<CameraKey>& keys, std::size_t i) {
  Numbers out{};
  if (i == 0 || i + 1 == keys.size()) return out;
  const Numbers a = numbers_of(keys[i - 1]), b = numbers_of(keys[i]), c = numbers_of(keys[i + 1]);
  const double h0 = keys[i].time - keys[i - 1].time, h1 = keys[i + 1].time - keys[i].time;
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = slope_between((b[k] - a[k]) / h0, h0, (c[k] - b[k]) / h1, h1);
  return out;
}

std::optional<Eigen::Vector3d> read_place(TomlTable& table, const char* key) {
  const auto numbers = table.numbers(key, 3, kPlaces, Need::required);
  if (!numbers) return std::nullopt;
  return Eigen::Vector3d((*numbers)[0], (*numbers)[1], (*numbers)[2]);
}

void check_view(TomlTable& table, const Eigen::Vector3d& eye, const Eigen::Vector3d& look_at) {
  const Eigen::Vector3d view = look_at - eye;
  if (view.norm() < 1e-3) {
    table.fault("look_at", "look_at is less than 1 mm from eye, expected a place to look at: move one of them");
  } else if (std::asin(std::min(1.0, std::abs(view.z()) / view.norm())) > kSteepest) {
    table.fault("look_at", "the view is within 2 degrees of vertical, expected less, as z is up: move eye to the side");
  }
}

void read_keys(TomlTable& root, CameraScript& script) {
  for (TomlTable& table : root.tables("key")) {
    table.set_title(fmt::format("key {}", script.keys.size() + 1));
    CameraKey key;
    key.time = table.number("time", kTimes, Need::required).value_or(0);
    const auto eye = read_place(table, "eye"), look_at = read_place(table, "look_at");
    key.field_of_view = table.number("field_of_view_deg", {"degrees", 2, 120}).value_or(kFieldOfView);
    if (eye && look_at) {
      check_view(table, *eye, *look_at);
      key.eye = *eye;
      key.look_at = *look_at;
    }
    if (!script.keys.empty() && key.time <= script.keys.back().time)
      table.fault("time", fmt::format("time is {:g} s, expected more than that of the key before, {:g} s", key.time,
                                      script.keys.back().time));
    script.keys.push_back(key);
  }
  if (script.keys.empty()) root.fault("", "there is no [[key]], expected at least one: time, eye and look_at");
}

void read_follow(TomlTable& root, CameraScript& script) {
  TomlTable table = root.table("follow");
  if (!table.exists()) return;
  CameraFollow follow;
  follow.device = static_cast<std::uint32_t>(table.integer("device", 0, 7).value_or(0));
  follow.share = table.number("share", {"", 0, 1}).value_or(1);
  follow.smooth = table.number("smooth", {"s", 0, 10}).value_or(follow.smooth);
  script.follow = follow;
}

void read_captions(TomlTable& root, CameraScript& script) {
  for (TomlTable& table : root.tables("caption")) {
    Caption caption;
    caption.from = table.number("from", kTimes, Need::required).value_or(0);
    caption.to = table.number("to", kTimes, Need::required).value_or(caption.from + 1);
    caption.text = table.text("text", Need::required).value_or("");
    if (caption.to <= caption.from)
      table.fault("to", fmt::format("to is {:g} s, expected more than from, {:g} s", caption.to, caption.from));
    if (!script.captions.empty() && caption.from < script.captions.back().to)
      table.fault("from", "the caption begins before the one above it ends, expected one after the other");
    script.captions.push_back(caption);
  }
}

CameraScript read(TomlFile file) {
  CameraScript script;
  TomlTable root = file.root();
  root.text("description");
  read_keys(root, script);
  read_follow(root, script);
  read_captions(root, script);
  file.finish();
  return script;
}

}  // namespace

CameraScript read_camera_script(const std::string& file) { return read(TomlFile::read(file)); }

CameraScript parse_camera_script(const std::string& text, const std::string& file) {
  return read(TomlFile::parse(text, file));
}

CameraKey camera_at(const std::vector<CameraKey>& keys, double time) {
  if (time <= keys.front().time) return keys.front();
  if (time >= keys.back().time) return keys.back();
  const auto after =
      std::upper_bound(keys.begin(), keys.end(), time, [](double t, const CameraKey& key) { return t < key.time; });
  const auto i = static_cast<std::size_t>(after - keys.begin() - 1);
  const double h = keys[i + 1].time - keys[i].time, s = (time - keys[i].time) / h;
  const Numbers a = numbers_of(keys[i]), b = numbers_of(keys[i + 1]), p = slopes_at(keys, i),
                q = slopes_at(keys, i + 1);
  Numbers out{};
  for (std::size_t k = 0; k < out.size(); ++k) {
    const double value = a[k] + (b[k] - a[k]) * s * s * (3 - 2 * s) + h * s * (1 - s) * ((1 - s) * p[k] - s * q[k]);
    out[k] = std::clamp(value, std::min(a[k], b[k]), std::max(a[k], b[k]));  // against rounding alone
  }
  return {time, {out[0], out[1], out[2]}, {out[3], out[4], out[5]}, out[6]};
}

ShownCaption caption_at(const std::vector<Caption>& captions, double time) {
  for (const Caption& caption : captions) {
    if (time < caption.from || time > caption.to) continue;
    const double inside = std::min(time - caption.from, caption.to - time);
    return {caption.text, std::clamp(inside / kFade, 0.0, 1.0)};
  }
  return {};
}

}  // namespace palp
