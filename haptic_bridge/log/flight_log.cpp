#include "haptic_bridge/log/flight_log.h"

#include <algorithm>

#include <fmt/format.h>

#include "haptic_bridge/log/output_file.h"

namespace palp {

namespace {

using Row = fmt::memory_buffer;

constexpr std::size_t kMostColumn = 17;  // characters, with the comma behind it

struct Column {
  const char* name;
  const char* meaning;
  void (*put)(Row&, const TickRecord&);
};

void number(Row& row, double value) { fmt::format_to(std::back_inserter(row), "{:.9g}", value); }
template <class T>
void integer(Row& row, T value) {
  fmt::format_to(std::back_inserter(row), "{}", value);
}
void microseconds(Row& row, std::int64_t t_ns) { number(row, 1e-3 * static_cast<double>(t_ns)); }

// clang-format off
#define PALP_VECTOR(name, meaning, value) \
  {name "_x" , meaning ", x", [](Row& o, const TickRecord& r) { number(o, (value).x()); }}, \
  {name "_y" , meaning ", y", [](Row& o, const TickRecord& r) { number(o, (value).y()); }}, \
  {name "_z" , meaning ", z", [](Row& o, const TickRecord& r) { number(o, (value).z()); }}

const Column kColumns[] = {
  {"tick", "counted from 1", [](Row& o, const TickRecord& r) { integer(o, r.tick); }},
  {"t_ns", "time of the tick, CLOCK_MONOTONIC of this host [ns]", [](Row& o, const TickRecord& r) { integer(o, r.t_ns); }},
  {"lateness_us", "behind its deadline [us]", [](Row& o, const TickRecord& r) { microseconds(o, r.lateness_ns); }},
  {"missed", "whole periods skipped before this tick", [](Row& o, const TickRecord& r) { integer(o, r.missed); }},
  {"state", "waiting, ready, engaged, idle, degraded, stale, locked or fault", [](Row& o, const TickRecord& r) { integer(o, to_string(r.state)); }},
  {"good_reading", "1: the device gave a usable pose", [](Row& o, const TickRecord& r) { integer(o, int{r.good_reading}); }},
  {"hand_on", "1: the hand holds the handle, the motors are on, the emergency stop is closed, the arm is not shifted", [](Row& o, const TickRecord& r) { integer(o, int{r.engaged_device}); }},
  {"cut", "1: a safety cut set the wrench to zero", [](Row& o, const TickRecord& r) { integer(o, int{r.cut}); }},
  {"reduced", "1: the power limit took force away", [](Row& o, const TickRecord& r) { integer(o, int{r.reduced}); }},
  {"alarms", "of the device, as it numbers them", [](Row& o, const TickRecord& r) { integer(o, r.alarms); }},
  {"verdict", "on the sample that came in this tick, empty if none came", [](Row& o, const TickRecord& r) { if (r.verdict >= 0) integer(o, to_string(static_cast<Verdict>(r.verdict))); }},
  {"sequence", "of the sample in use, 0: none yet", [](Row& o, const TickRecord& r) { integer(o, r.sequence); }},
  {"age_us", "of the sample in use, since it was received [us]", [](Row& o, const TickRecord& r) { microseconds(o, r.age_ns); }},
  {"delay_us", "since the device state that the sample answers was read [us]", [](Row& o, const TickRecord& r) { microseconds(o, r.delay_ns); }},
  {"sim_time_s", "of the sample in use [s]", [](Row& o, const TickRecord& r) { number(o, r.sim_time); }},
  PALP_VECTOR("device", "position of the handle, world frame [m]", r.device.position),
  {"device_qx", "orientation of the handle, x", [](Row& o, const TickRecord& r) { number(o, r.device.orientation.x()); }},
  {"device_qy", "orientation of the handle, y", [](Row& o, const TickRecord& r) { number(o, r.device.orientation.y()); }},
  {"device_qz", "orientation of the handle, z", [](Row& o, const TickRecord& r) { number(o, r.device.orientation.z()); }},
  {"device_qw", "orientation of the handle, w", [](Row& o, const TickRecord& r) { number(o, r.device.orientation.w()); }},
  PALP_VECTOR("velocity", "of the handle [m/s]", r.device.linear),
  PALP_VECTOR("angular_velocity", "of the handle, world frame [rad/s]", r.device.angular),
  PALP_VECTOR("proxy", "position of the proxy in the sample in use [m]", r.proxy),
  PALP_VECTOR("model_force", "of the local model on the hand, before the limits [N]", r.model.force),
  PALP_VECTOR("model_torque", "of the local model on the hand, before the limits [N m]", r.model.torque),
  PALP_VECTOR("force", "sent to the device, on the hand [N]", r.sent.force),
  PALP_VECTOR("torque", "sent to the device, on the hand, about the handle [N m]", r.sent.torque),
  {"stale_scale", "weight of the local model for its age, 1..0", [](Row& o, const TickRecord& r) { number(o, r.stale_scale); }},
  {"engagement", "weight of all force, 0..1", [](Row& o, const TickRecord& r) { number(o, r.engagement); }},
  {"blend_linear", "local stiffness of the sample in use, 0..1", [](Row& o, const TickRecord& r) { number(o, r.blend_linear); }},
  {"blend_angular", "the same for rotation", [](Row& o, const TickRecord& r) { number(o, r.blend_angular); }},
  {"energy_linear", "that coupling and network may still give the hand [J]", [](Row& o, const TickRecord& r) { number(o, r.energy_linear); }},
  {"energy_angular", "the same for rotation [J]", [](Row& o, const TickRecord& r) { number(o, r.energy_angular); }},
  {"damping_linear", "of the passivity controller [N s/m]", [](Row& o, const TickRecord& r) { number(o, r.damping_linear); }},
  {"damping_angular", "the same for rotation [N m s/rad]", [](Row& o, const TickRecord& r) { number(o, r.damping_angular); }},
  {"duration_us", "that the tick took, the device's calls included [us]", [](Row& o, const TickRecord& r) { microseconds(o, r.duration_ns); }},
  {"gains_share", "of the profile's gains, as the link allows, 0..1", [](Row& o, const TickRecord& r) { number(o, r.gains_share); }},
};
#undef PALP_VECTOR
// clang-format on

}  // namespace

FlightLog::FlightLog(std::size_t ticks) : ring_(std::max<std::size_t>(ticks, 1) + 1), inputs_(ring_.size()) {}

std::size_t most_csv_bytes(std::size_t ticks) { return (ticks + 2) * std::size(kColumns) * kMostColumn; }

void FlightLog::write_csv(const std::string& path) const {
  write_whole_file("flight log", path, [&](OutputFile& file) {
    Row row;
    for (const Column& column : kColumns)
      fmt::format_to(std::back_inserter(row), "{}{}", row.size() ? "," : "", column.name);
    row.push_back('\n');
    for (std::size_t i = 0; i < size(); ++i) {
      const char* separator = "";
      for (const Column& column : kColumns) {
        fmt::format_to(std::back_inserter(row), "{}", separator);
        column.put(row, at(i));
        separator = ",";
      }
      row.push_back('\n');
      if (row.size() > 1 << 16) {
        file.write(row);
        row.clear();
      }
    }
    file.write(row);
  });
}

std::string flight_log_columns() {
  std::string text;
  for (const Column& column : kColumns) text += fmt::format("{}: {}\n", column.name, column.meaning);
  return text;
}

}  // namespace palp
