// Tells people how the bridge is: Status and Events on the bus, lines in the log, the summary at the end.
// One thread, not the loop's.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "haptic_bridge/peers.h"
#include "haptic_bridge/report.h"
#include "idl/bus.h"

namespace palp {

class StatusReporter {
 public:
  // process: "haptic_bridge 0". bus_name: "cyclone, domain 0".
  StatusReporter(Bus& bus, std::string process, std::string bus_name);

  // Where the scene puts the proxy of this device; none, and said so, if it has no such proxy.
  std::optional<RigidState> home_in(const SceneDescription& scene, std::uint32_t device);

  // The tell_... are called about ten times a second; each publishes a Status, and an Event when something has changed.
  void tell_waiting(const Reader<SceneDescription>& scenes, const BusLink& link);
  void tell_started(const std::string& scheduling);
  void tell_running(LoopPorts& ports, const BusLink& link, const BridgePeers& peers);
  void tell_stopped(const std::string& state, const std::string& text);

  // Everything but device, scheduling, log and trouble.
  Summary summary(const LoopReport& report, const LoopPorts& ports, const BusLink& link) const;
  // Last words: prints the summary, writes it beside the flight log (.json), publishes state and trouble.
  void finish(const Summary& summary, const std::string& path);

 private:
  void publish(const std::string& state, const std::string& text, std::vector<Metric> metrics);
  void announce(Severity severity, const std::string& text);
  void tell_servers(const std::string& two_servers, const BusLink& link, const BridgePeers& peers);
  void tell_state(const std::string& trouble);
  void tell_strain(const std::string& trouble, std::int64_t now_ns);

  std::unique_ptr<Writer<Status>> status_;
  std::unique_ptr<Writer<Event>> event_;
  std::string process_, bus_name_;
  std::string trouble_;                  // of the last status
  LoopReport report_;                    // newest
  LoopState told_ = LoopState::waiting;  // by an Event, with this reason
  std::string told_trouble_;
  std::int64_t t_strain_told_ns_ = 0;  // 0: never
  std::uint64_t told_session_ = 0, told_rival_ = 0;
  std::int64_t t_window_ns_ = 0;
  std::uint64_t ticks_in_window_ = 0;
  double rate_hz_ = 0;
};

}  // namespace palp
