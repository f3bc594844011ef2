#include "haptic_bridge/report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "idl/validate.h"

namespace palp {

namespace {

double as_number(std::uint64_t n) { return static_cast<double>(n); }

std::uint64_t dropped(const LoopReport& report, const DropCounts& drops) {
  const auto of = [&](Verdict v) { return report.verdicts[static_cast<std::size_t>(v)]; };
  return drops.wrong_version + drops.not_finite + drops.malformed + of(Verdict::not_finite) + of(Verdict::bad_range) +
         of(Verdict::bad_gains) + of(Verdict::out_of_order);
}

double find(const std::vector<Metric>& metrics, const char* name) {
  for (const Metric& m : metrics) {
    if (m.name == name) return m.value;
  }
  return 0;
}

// Why the arm itself gives no force, or empty.
const char* without_power(const LoopReport& report) {
  if (!report.chain_closed) return "the emergency stop is open: the force is zero";
  if (!report.powered) return "the arm's motors have no power, or have had it for too short a time: the force is zero";
  return "";
}

}  // namespace

std::vector<Metric> bridge_metrics(const LoopReport& report, const LoopPorts& ports, const BusLink& link,
                                   double rate_hz) {
  const DropCounts drops = link.drops();
  return {
      {"rate_hz", rate_hz},
      {"ticks", as_number(report.ticks)},
      {"lateness_p50_us", ports.lateness.quantile_us(0.5)},
      {"lateness_p99_us", ports.lateness.quantile_us(0.99)},
      {"lateness_p999_us", ports.lateness.quantile_us(0.999)},
      {"lateness_max_us", ports.lateness.max_us()},
      {"overruns", as_number(report.missed)},
      {"tick_p50_us", ports.duration.quantile_us(0.5)},
      {"tick_p99_us", ports.duration.quantile_us(0.99)},
      {"tick_max_us", ports.duration.max_us()},
      {"cpu_per_tick_us", report.ticks > 0 ? 1e-3 * static_cast<double>(ports.cpu_ns) / as_number(report.ticks) : 0},
      {"sample_age_p50_ms", 1e-3 * ports.age.quantile_us(0.5)},
      {"sample_age_p99_ms", 1e-3 * ports.age.quantile_us(0.99)},
      {"sample_age_max_ms", 1e-3 * ports.age.max_us()},
      {"round_trip_p50_ms", 1e-3 * ports.delay.quantile_us(0.5)},
      {"round_trip_p99_ms", 1e-3 * ports.delay.quantile_us(0.99)},
      {"send_p50_us", link.send_time().quantile_us(0.5)},
      {"send_p99_us", link.send_time().quantile_us(0.99)},
      {"force_n", report.force},
      {"torque_nm", report.torque},
      {"peak_force_n", report.peak_force},
      {"peak_torque_nm", report.peak_torque},
      {"received_samples", as_number(link.received())},
      {"lost_samples", as_number(drops.lost)},
      {"dropped_samples", as_number(dropped(report, drops))},
      {"stale_events", as_number(report.stale_events)},
      {"safety_cuts", as_number(report.cuts)},
      {"bad_readings", as_number(report.bad_readings)},
      {"trips", as_number(report.trips)},
      {"damped_ticks", as_number(report.damped_ticks)},
      {"gains_share", report.gains_share},
      {"clutch", report.shifted ? 1.0 : 0.0},
      {"motion_scale", report.motion_scale},
      {"force_scale", report.force_scale},
      {"reach_x_m", report.reach.center[0]},
      {"reach_y_m", report.reach.center[1]},
      {"reach_z_m", report.reach.center[2]},
      {"reach_half_x_m", report.reach.half[0]},
      {"reach_half_y_m", report.reach.half[1]},
      {"reach_half_z_m", report.reach.half[2]},
  };
}

std::string bridge_trouble(const LoopReport& report, const BusLink& link) {
  std::string version = wrong_version_sentence("palp/proxy", link.drops());
  if (!version.empty()) return version;
  const auto of = [&](Verdict v) { return report.verdicts[static_cast<std::size_t>(v)]; };
  if (of(Verdict::bad_gains) > 0 && of(Verdict::restarted) == 0)
    return "the server answers with coupling gains above those that were asked for: its samples are refused";
  switch (report.state) {
    case LoopState::fault:
      return to_string(report.fault);
    case LoopState::stale:
      return "the server has fallen silent: the force is zero until its samples are fresh again";
    case LoopState::waiting:
      return link.servers() == 0 ? "no sim_server is heard: start palp-sim-server with the same --dds domain"
                                 : "a sim_server is there but has not answered yet";
    case LoopState::idle:
      if (*without_power(report)) return without_power(report);
      if (report.shifted) return "the shift button is pressed: the hand moves the arm and not the tool";
      if (!report.dead_man) return "the hand is off the dead-man switch: the force is zero";
      return "the simulation is paused, unhealthy or not coupled to this device: the force is zero";
    case LoopState::degraded:
      return "samples are late: the force fades into damping";
    case LoopState::locked:
      if (*without_power(report)) return without_power(report);
      return "the force was cut: let go of the handle and take hold of it again";
    case LoopState::ready:
    case LoopState::engaged:
      return report.strained ? "the arm is at a bound, too warm or saturated: the force is halved" : "";
  }
  return "";
}

std::string to_text(const Summary& s) {
  const auto m = [&](const char* name) { return find(s.metrics, name); };
  std::string text = fmt::format("{}: {}, {}\n", s.process, s.device, s.bus);
  text += fmt::format("  scheduling   {}\n", s.scheduling);
  text += fmt::format("  rate         {:.1f} Hz over {:.0f} ticks, {:.0f} periods missed\n", s.rate_hz, m("ticks"),
                      m("overruns"));
  text += fmt::format("  lateness     median {:.0f} us, 99 % {:.0f} us, 99.9 % {:.0f} us, max {:.0f} us\n",
                      m("lateness_p50_us"), m("lateness_p99_us"), m("lateness_p999_us"), m("lateness_max_us"));
  text += fmt::format(
      "  tick         median {:.1f} us, 99 % {:.1f} us, max {:.0f} us with the device; CPU {:.1f} us, waking "
      "included\n",
      m("tick_p50_us"), m("tick_p99_us"), m("tick_max_us"), m("cpu_per_tick_us"));
  text += fmt::format(
      "  sample age   median {:.2f} ms, 99 % {:.2f} ms, max {:.2f} ms; device to force median {:.2f} ms, 99 % {:.2f} "
      "ms\n",
      m("sample_age_p50_ms"), m("sample_age_p99_ms"), m("sample_age_max_ms"), m("round_trip_p50_ms"),
      m("round_trip_p99_ms"));
  text += fmt::format("  force        peak {:.2f} N, {:.3f} N m; {:.0f} safety cuts\n", m("peak_force_n"),
                      m("peak_torque_nm"), m("safety_cuts"));
  text += fmt::format("  samples      {:.0f} received, {:.0f} lost, {:.0f} dropped, server silent {:.0f} times\n",
                      m("received_samples"), m("lost_samples"), m("dropped_samples"), m("stale_events"));
  text += fmt::format("  flight log   {}\n", s.log);
  text += fmt::format("  state        {}{}\n", s.state, s.trouble.empty() ? "" : ": " + s.trouble);
  return text;
}

Json json_of(const Summary& s) {
  Json json{{"process", s.process}, {"device", s.device}, {"scheduling", s.scheduling}, {"bus", s.bus},
            {"log", s.log},         {"state", s.state},   {"trouble", s.trouble},       {"healthy", s.trouble.empty()}};
  for (const Metric& m : s.metrics) json["metrics"][m.name] = m.value;
  return json;
}

}  // namespace palp
