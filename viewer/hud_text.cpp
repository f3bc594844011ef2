#include "viewer/hud_text.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "viewer/metric.h"

namespace palp {
namespace {

constexpr double kOldFrame = 0.25;      // [s]
constexpr double kSlowFactor = 0.97;    // real-time factor below which the simulation is slow
constexpr double kLateBridge = 0.5e-3;  // [s]

const std::string kUnknown = "–";

std::string grouped(std::size_t n) {
  std::string digits = std::to_string(n);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<std::size_t>(at), 1, ' ');
  }
  return digits;
}

void keep_larger(std::optional<double>& kept, const std::optional<double>& other) {
  if (other && (!kept || *other > *kept)) kept = other;
}

}  // namespace

std::string format_time(double seconds) {
  const double s = std::abs(seconds);
  if (s >= 10) return fmt::format("{:.0f} s", seconds);
  if (s >= 1) return fmt::format("{:.1f} s", seconds);
  if (s >= 0.01) return fmt::format("{:.0f} ms", 1e3 * seconds);
  if (s >= 0.1e-3) return fmt::format("{:.2f} ms", 1e3 * seconds);
  return fmt::format("{:.0f} us", 1e6 * seconds);
}

std::vector<HudRow> hud_rows(const HudData& d) {
  std::vector<HudRow> rows;
  rows.push_back({"view", fmt::format("{:.0f} pictures/s", d.shown_rate_hz)});
  rows.push_back({"particles", d.connected
                                   ? fmt::format("{}  ·  {:.0f} frames/s", grouped(d.particles), d.frame_rate_hz)
                                   : kUnknown});
  const bool old = d.frame_age && *d.frame_age > kOldFrame && !d.paused;
  std::string age = d.frame_age ? fmt::format("{} old", format_time(*d.frame_age)) : kUnknown;
  if (d.lost_frames > 0) age += fmt::format("  ·  {} lost", grouped(d.lost_frames));
  if (!d.way.empty()) age += fmt::format("  ·  by {}", d.way);
  rows.push_back({"data", age, old});
  std::string time = d.sim_time ? fmt::format("{:.2f} s", *d.sim_time) : kUnknown;
  const bool running = !d.paused && !d.server_ended;
  if (d.paused) time += "  ·  paused, ×0 real time";
  if (running && d.real_time_factor) time += fmt::format("  ·  ×{:.2f} real time", *d.real_time_factor);
  rows.push_back({"simulated", time, running && d.real_time_factor && *d.real_time_factor < kSlowFactor, true});
  rows.push_back({"step", d.step_time ? format_time(*d.step_time) : kUnknown});
  std::string bridge = d.bridge_rate_hz ? fmt::format("{:.0f} Hz", *d.bridge_rate_hz) : "";
  if (d.bridge_late) bridge += fmt::format("{}{} late", bridge.empty() ? "" : "  ·  ", format_time(*d.bridge_late));
  if (!d.hand_state.empty()) bridge = bridge.empty() ? d.hand_state : d.hand_state + "  ·  " + bridge;
  if (d.bridge_data_age) bridge += fmt::format("  ·  {} old", format_time(*d.bridge_data_age));
  if (!d.scales.empty()) bridge += fmt::format("{}{}", bridge.empty() ? "" : "  ·  ", d.scales);
  rows.push_back({"bridge", bridge.empty() ? kUnknown : bridge, d.bridge_late && *d.bridge_late > kLateBridge});
  std::string force = d.force ? fmt::format("{:.2f} N", *d.force) : kUnknown;
  if (d.force && d.torque) force += fmt::format("  ·  {:.3f} N m", *d.torque);
  rows.push_back({"force", force, false, true});
  std::string contact = d.contact ? fmt::format("{:.0f} % rigid", 100 * *d.contact) : kUnknown;
  if (d.touched) contact += fmt::format("  ·  {:.1f} cm² touched", 1e4 * d.touched->area);
  if (d.touched && d.touched->pressure) contact += fmt::format(", {:.0f} Pa in the mean", *d.touched->pressure);
  rows.push_back({"contact", contact, false, d.touched.has_value()});
  const std::string scale = fmt::format("{:g} N = {:.0f} mm", d.arrow_force, 1e3 * d.arrow_length);
  rows.push_back({"arrow", d.force ? scale : kUnknown});
  return rows;
}

std::string hud_banner(const HudData& d) {
  if (!d.connected) return "waiting for sim_server";
  if (d.server_state == "fault") {
    return fmt::format("sim_server stopped: {}", d.server_text.empty() ? "fault" : d.server_text);
  }
  if (d.server_ended) return "sim_server has ended";
  if (d.server_silent) {
    return fmt::format("sim_server has ended or hangs: nothing heard for {}", format_time(*d.server_silent));
  }
  if (!d.hand_trouble.empty()) return d.hand_trouble;
  if (!d.note.empty()) return d.note;
  if (d.surfaces_built) return fmt::format("building surfaces: {:.0f} %", std::floor(100 * *d.surfaces_built));
  if (d.paused) return "paused";
  if (d.frame_age && *d.frame_age > 1) return fmt::format("no particles for {}", format_time(*d.frame_age));
  if (!d.frame_age) return "waiting for particles";
  return "";
}

void read_status(const std::map<std::string, Status>& newest, HudData& d) {
  for (const auto& [process, status] : newest) {
    if (process.starts_with("sim_server")) {
      d.server_state = status.state;
      d.server_text = status.text;
      if (status.state == "paused") d.paused = true;
      d.real_time_factor = metric(status, "real_time_factor");
      d.step_time = metric(status, "step_p50_us", 1e-6);
      d.kinetic_energy = metric(status, "kinetic_energy_J");
    } else if (process.starts_with("haptic_bridge")) {
      d.hand_state = d.bridge_rate_hz ? "" : status.state;
      const bool clutched = metric(status, "clutch").value_or(0) > 0;
      const bool strained = status.state == "engaged" && !status.text.empty();
      const bool held_back =
          status.state == "locked" || status.state == "fault" || status.state == "stale" || clutched || strained;
      const auto scale = [&status = status](const char* name) { return metric(status, name).value_or(1); };
      d.scales = d.bridge_rate_hz || (scale("motion_scale") == 1 && scale("force_scale") == 1)
                     ? ""
                     : fmt::format("motion ×{:g}, force ×{:g}", scale("motion_scale"), scale("force_scale"));
      if (held_back && d.hand_trouble.empty())
        d.hand_trouble =
            fmt::format("{} is {}{}{}", process, status.state, status.text.empty() ? "" : ": ", status.text);
      keep_larger(d.bridge_late, metric(status, "lateness_p99_us", 1e-6));
      keep_larger(d.bridge_data_age, metric(status, "sample_age_p50_ms", 1e-3));
      if (!d.bridge_rate_hz) d.bridge_rate_hz = metric(status, "rate_hz");
    }
  }
}

}  // namespace palp
