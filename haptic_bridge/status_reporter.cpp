#include "haptic_bridge/status_reporter.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

#include "idl/clock.h"
#include "idl/validate.h"

namespace palp {

namespace {

constexpr std::int64_t kRateWindowNs = 1'000'000'000;
constexpr std::int64_t kStrainAgainNs = 5'000'000'000;  // an arm at its limits goes past them again and again

// States that people are told of when they come; the others follow from them or flicker.
bool worth_an_event(LoopState state) {
  return state == LoopState::engaged || state == LoopState::stale || state == LoopState::fault ||
         state == LoopState::idle || state == LoopState::locked;
}

// States that come for several reasons, one after the other.
bool has_reasons(LoopState state) { return state == LoopState::idle || state == LoopState::locked; }

}  // namespace

StatusReporter::StatusReporter(Bus& bus, std::string process, std::string bus_name)
    : status_(bus.writer<Status>()),
      event_(bus.writer<Event>()),
      process_(std::move(process)),
      bus_name_(std::move(bus_name)) {}

std::optional<RigidState> StatusReporter::home_in(const SceneDescription& scene, std::uint32_t device) {
  std::string others;
  for (const ProxyDescription& proxy : scene.proxies) {
    if (proxy.device == device) return to_state(proxy.pose, TwistD{});
    others += fmt::format("{}{}", others.empty() ? "" : ", ", proxy.device);
  }
  announce(Severity::warning, fmt::format("scene '{}' has no proxy for device {} (it has {}): waiting for one that has",
                                          scene.name, device, others.empty() ? "none" : others));
  return std::nullopt;
}

void StatusReporter::tell_waiting(const Reader<SceneDescription>& scenes, const BusLink& link) {
  std::string text = wrong_version_sentence("palp/scene", scenes.drops());
  if (text.empty()) text = wrong_version_sentence("palp/proxy", link.drops());
  if (text.empty())
    text = fmt::format(
        "waiting for a scene: {} on {}",
        scenes.matched_writers() == 0 ? "no sim_server is heard" : "a sim_server is there but has sent none",
        bus_name_);
  if (text != trouble_) spdlog::info("{}: {}", process_, text);
  trouble_ = text;
  publish("waiting", text, {});
}

void StatusReporter::tell_started(const std::string& scheduling) {
  t_window_ns_ = now_ns();
  announce(Severity::info, fmt::format("the loop runs: {}", scheduling));
}

void StatusReporter::tell_running(LoopPorts& ports, const BusLink& link, const BridgePeers& peers) {
  ports.report.take(report_);
  const std::int64_t now = now_ns();
  if (now - t_window_ns_ >= kRateWindowNs) {
    rate_hz_ = 1e9 * static_cast<double>(report_.ticks - ticks_in_window_) / static_cast<double>(now - t_window_ns_);
    ticks_in_window_ = report_.ticks;
    t_window_ns_ = now;
  }
  const std::string two_servers = peers.two_servers(link);
  tell_servers(two_servers, link, peers);
  std::string trouble = bridge_trouble(report_, link);
  if (trouble.empty()) trouble = two_servers;
  tell_state(trouble);
  tell_strain(trouble, now);
  trouble_ = trouble;
  publish(to_string(report_.state), trouble, bridge_metrics(report_, ports, link, rate_hz_));
}

void StatusReporter::tell_servers(const std::string& two_servers, const BusLink& link, const BridgePeers& peers) {
  if (report_.server_session != told_session_) {
    if (told_session_ != 0 && report_.server_session == told_rival_) {
      announce(Severity::warning,
               fmt::format("the server has fallen silent, and {} takes its place: the force begins again on a ramp",
                           peers.name_of_session(report_.server_session)));
    } else if (told_session_ != 0) {
      announce(Severity::info, "the server was restarted: the force begins again on a ramp");
    }
    told_session_ = report_.server_session;
    told_rival_ = 0;
  }
  if (two_servers.empty() || link.rival_server() == told_rival_) return;
  told_rival_ = link.rival_server();
  announce(Severity::warning, two_servers);
}

void StatusReporter::tell_state(const std::string& trouble) {
  const bool other_reason = has_reasons(report_.state) && trouble != told_trouble_;
  if ((report_.state != told_ || other_reason) && worth_an_event(report_.state)) {
    told_ = report_.state;
    told_trouble_ = trouble;
    if (told_ == LoopState::engaged) {
      announce(Severity::info, "engaged: the hand feels the simulation");
    } else {
      announce(told_ == LoopState::fault ? Severity::fault : Severity::warning, trouble);
    }
  } else if (!trouble.empty() && trouble != trouble_ && report_.state == LoopState::waiting) {
    spdlog::warn("{}: {}", process_, trouble);
  }
}

void StatusReporter::tell_strain(const std::string& trouble, std::int64_t now_ns) {
  if (!report_.strained || report_.state != LoopState::engaged) return;
  if (t_strain_told_ns_ != 0 && now_ns - t_strain_told_ns_ < kStrainAgainNs) return;
  t_strain_told_ns_ = now_ns;
  announce(Severity::warning, trouble);
}

void StatusReporter::tell_stopped(const std::string& state, const std::string& text) {
  spdlog::info("{}: {}", process_, text);
  publish(state, text, {});
}

Summary StatusReporter::summary(const LoopReport& report, const LoopPorts& ports, const BusLink& link) const {
  Summary s;
  s.process = process_;
  s.bus = bus_name_;
  s.state = to_string(report.state);
  const double seconds = 1e-9 * static_cast<double>(report.t_last_ns - report.t_first_ns);
  s.rate_hz = seconds > 0 ? static_cast<double>(report.ticks - 1) / seconds : 0;
  s.metrics = bridge_metrics(report, ports, link, s.rate_hz);
  return s;
}

void StatusReporter::finish(const Summary& summary, const std::string& path) {
  fmt::print("{}", to_text(summary));
  std::fflush(stdout);
  try {
    write_json(path, json_of(summary));
  } catch (const std::exception& error) {
    spdlog::error("{}: {}", process_, error.what());
  }
  if (summary.trouble.empty()) {
    publish("stopped", "", summary.metrics);
  } else {
    announce(Severity::fault, summary.trouble);
    publish("fault", summary.trouble, summary.metrics);
  }
}

void StatusReporter::publish(const std::string& state, const std::string& text, std::vector<Metric> metrics) {
  Status status;
  status.process = process_;
  status.state = state;
  status.text = text;
  status.metrics = std::move(metrics);
  status_->publish(status);
}

void StatusReporter::announce(Severity severity, const std::string& text) {
  const auto level = severity == Severity::fault     ? spdlog::level::err
                     : severity == Severity::warning ? spdlog::level::warn
                                                     : spdlog::level::info;
  spdlog::log(level, "{}: {}", process_, text);
  Event event;
  event.process = process_;
  event.severity = severity;
  event.text = text;
  event_->publish(event);
}

}  // namespace palp
