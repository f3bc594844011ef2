// The three real processes in a DDS domain of their own, and a watcher on the bus that sees what they say.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "idl/bus.h"
#include "tests/support/eventually.h"
#include "tests/support/files.h"
#include "tests/support/process.h"

namespace palp::test {

using namespace std::chrono_literals;

inline const std::string kBin = PALP_BIN_DIR "/";
inline const std::string kHere = PALP_SOURCE_DIR "/tests/process/";

// The time that suffices for a machine with two slow cores and another build on it; nothing waits for it when all is
// well.
inline constexpr auto kPatience = std::chrono::milliseconds(30'000);

// Returns the number behind "name": in JSON text; NaN where there is none.
inline double number_in_json(const std::string& json, const std::string& name) {
  const std::string key = "\"" + name + "\": ";
  const std::size_t at = json.find(key);
  return at == std::string::npos ? std::nan("") : std::strtod(json.c_str() + at + key.size(), nullptr);
}

// Watches what the processes say, as anyone on the bus hears it. One thread.
class Watcher {
 public:
  explicit Watcher(const BusOptions& options)
      : bus_(open_bus(options)),
        proxies_(bus_->reader<ProxySample>()),
        statuses_(bus_->reader<Status>()),
        events_(bus_->reader<Event>()) {}

  void look() {
    std::vector<Received<ProxySample>> proxies;
    proxies_->take_all(proxies);
    for (const auto& p : proxies) {
      proxy = p.message;
      ++proxies_heard;
      if ((p.message.flags & kEngaged) != 0) ++engaged_heard;
    }
    std::vector<Received<Status>> statuses;
    statuses_->take_all(statuses);
    for (const auto& s : statuses) status[s.message.process] = s.message;
    std::vector<Received<Event>> news;
    events_->take_all(news);
    for (const auto& e : news) events.push_back(e.message);
  }
  // Looks until the condition holds or patience ends.
  bool sees(const std::function<bool()>& condition, std::chrono::milliseconds limit = kPatience) {
    return eventually([&] { return (look(), condition()); }, limit);
  }
  // Waits for two more statuses: the second was made after the call.
  bool hears_news_of(const std::string& process) {
    const std::uint64_t now = status[process].header.sequence;
    return sees([&] { return status[process].header.sequence >= now + 2; });
  }
  bool says(const std::string& process, const std::string& state) { return status[process].state == state; }
  // Returns a metric of the newest status; 0 where there is none.
  double metric(const std::string& process, const std::string& name) {
    for (const Metric& m : status[process].metrics)
      if (m.name == name) return m.value;
    return 0;
  }
  bool has_event(const std::string& text) const {
    return std::any_of(events.begin(), events.end(),
                       [&](const Event& e) { return e.text.find(text) != std::string::npos; });
  }
  Bus& bus() { return *bus_; }

  ProxySample proxy;
  std::uint64_t proxies_heard = 0, engaged_heard = 0;
  std::map<std::string, Status> status;
  std::vector<Event> events;

 private:
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Reader<ProxySample>> proxies_;
  std::unique_ptr<Reader<Status>> statuses_;
  std::unique_ptr<Reader<Event>> events_;
};

// A client of the server's commands. One thread.
class Client {
 public:
  explicit Client(Bus& bus)
      : session_(bus.session()), commands_(bus.writer<Command>()), replies_(bus.reader<CommandReply>()) {}

  // Asks until the server answers. That a writer knows of its reader does not mean that the reader knows of it, and
  // what is sent before it does is lost: only what follows an answer surely arrives.
  bool reaches_server() {
    return eventually([&] { return !ask(CommandKind::set_parameter, "are you there", "", 200ms).text.empty(); },
                      kPatience);
  }
  // Returns the reply to exactly this command; not ok and empty when none came.
  CommandReply ask(CommandKind kind, const std::string& name = {}, const std::string& value = {},
                   std::chrono::milliseconds limit = kPatience) {
    Command command;
    command.kind = kind;
    command.name = name;
    command.value = value;
    EXPECT_TRUE(commands_->publish(command));
    CommandReply answer;
    const auto answered = [&] {
      std::vector<Received<CommandReply>> all;
      replies_->take_all(all);
      for (const auto& r : all) {
        EXPECT_EQ(r.message.command_session, session_) << "a reply to nobody's command";
        if (r.message.command_sequence == command.header.sequence) answer = r.message;
      }
      return !answer.text.empty();
    };
    eventually(answered, limit);
    return answer;
  }

 private:
  std::uint64_t session_;
  std::unique_ptr<Writer<Command>> commands_;
  std::unique_ptr<Reader<CommandReply>> replies_;
};

// The processes of one test; those that still run are killed at its end.
class RunningSystem : public testing::Test {
 protected:
  RunningSystem() : domain_(1 + static_cast<int>(getpid() % 100)) {}

  BusOptions on(Vendor vendor) const {
    BusOptions options;
    options.vendor = vendor;
    options.domain = domain_;
    return options;
  }
  // Returns the same watcher for the whole test.
  Watcher& watch(Vendor vendor = Vendor::cyclone) {
    if (!watcher_) watcher_ = std::make_unique<Watcher>(on(vendor));
    return *watcher_;
  }

  void start_server(Vendor vendor = Vendor::cyclone, const std::vector<std::string>& more = {}) {
    start(server_, "palp-sim-server", vendor, {kHere + "small_tray.toml", "--backend", "cpu"}, more);
  }
  void start_bridge(Vendor vendor = Vendor::cyclone, const std::vector<std::string>& more = {}) {
    start(bridge_, "palp-haptic-bridge", vendor, {"--hand", kHere + "dip.toml", "--log", folder_ / "flight.csv"}, more);
  }
  void start_viewer(Vendor vendor = Vendor::cyclone, const std::vector<std::string>& more = {}) {
    start(viewer_, "palp-viewer", vendor, {"--headless", "--gpu", "cpu", "--size", "320x240", "--fps", "2"}, more);
  }
  std::unique_ptr<ChildProcess> start_tool(const std::string& name, Vendor vendor,
                                           const std::vector<std::string>& more) {
    std::unique_ptr<ChildProcess> tool;
    start(tool, name, vendor, {}, more);
    return tool;
  }

  // Waits until the hand feels the simulation: the server answers this bridge and the bridge pushes.
  bool force_is_felt(Watcher& watcher) {
    return watcher.sees([&] {
      return (watcher.proxy.flags & kEngaged) != 0 && watcher.says("haptic_bridge 0", "engaged") &&
             watcher.metric("haptic_bridge 0", "force_n") > 0.5;
    });
  }
  bool viewer_draws(Watcher& watcher) {
    return watcher.sees([&] { return watcher.says("viewer", "running") && watcher.metric("viewer", "frames") > 3; });
  }

  std::string said() const {
    std::string all;
    for (const char* name : {"palp-sim-server", "palp-haptic-bridge", "palp-viewer", "palp-record", "palp-replay"})
      all += text_of(folder_ / (std::string(name) + ".txt"));
    return all;
  }
  std::string summary(const std::string& program) const { return text_of(folder_ / (program + ".json")); }

  // SIGTERM; every process that was started must have been healthy.
  void stop_server() {
    EXPECT_EQ(server_->stop(), 0) << server_->output();
    EXPECT_NE(summary("palp-sim-server").find("\"healthy\": true"), std::string::npos) << summary("palp-sim-server");
  }
  void stop_bridge() {
    EXPECT_EQ(bridge_->stop(), 0) << bridge_->output();
    EXPECT_NE(summary("palp-haptic-bridge").find("\"healthy\": true"), std::string::npos)
        << summary("palp-haptic-bridge");
    EXPECT_GT(number_in_json(summary("palp-haptic-bridge"), "peak_force_n"), 0.5) << summary("palp-haptic-bridge");
  }
  void stop_viewer() {
    EXPECT_EQ(viewer_->stop(), 0) << viewer_->output();
    EXPECT_NE(summary("palp-viewer").find("\"healthy\": true"), std::string::npos) << summary("palp-viewer");
    EXPECT_GT(number_in_json(summary("palp-viewer"), "drawn_frames"), 0) << summary("palp-viewer");
  }

  ScratchFolder folder_;
  const int domain_;
  std::unique_ptr<ChildProcess> server_, bridge_, viewer_;

 private:
  void start(std::unique_ptr<ChildProcess>& child, const std::string& name, Vendor vendor,
             const std::vector<std::string>& usual, const std::vector<std::string>& more) {
    std::vector<std::string> command{kBin + name, "--dds", to_string(vendor), "--domain", std::to_string(domain_)};
    command.insert(command.end(), usual.begin(), usual.end());
    if (name != "palp-replay") command.insert(command.end(), {"--summary", folder_ / (name + ".json")});
    command.insert(command.end(), more.begin(), more.end());
    child.reset();  // what ran before is gone first
    child = std::make_unique<ChildProcess>(command, folder_ / (name + ".txt"));
  }

  std::unique_ptr<Watcher> watcher_;
};

}  // namespace palp::test
