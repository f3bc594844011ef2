// The real server with four weights in the air, each on a real bridge of its own: what the fault rows are provoked in.
#pragma once

#include <csignal>

#include <sched.h>

#include "idl/clock.h"
#include "tests/process/flight.h"

namespace palp::test {

// Where this is allowed, the calling thread and what it starts go before other work while one lives: what is judged
// here is not how a busy machine shares its time.
class Urgent {
 public:
  Urgent() {
    const sched_param first{40};
    allowed_ = sched_setscheduler(0, SCHED_FIFO, &first) == 0;
  }
  ~Urgent() {
    const sched_param usual{0};
    if (allowed_) sched_setscheduler(0, SCHED_OTHER, &usual);
  }
  Urgent(const Urgent&) = delete;
  Urgent& operator=(const Urgent&) = delete;

 private:
  bool allowed_ = false;
};

// Something that happens to a simulated Virtuose, [s] since it was opened. Half a millisecond lies between the steps of
// its controller, so that whoever asks at that time or later is told.
struct ArmEvent {
  std::string name;
  double time = 0, duration = 0;  // 0: for ever
  double value = 0;
  std::string call;
};

inline std::string text_of(const ArmEvent& e) {
  std::ostringstream text;
  text.precision(9);
  text << "[[event]]\nevent = \"" << e.name << "\"\ntime = " << e.time << "\n";
  if (e.duration > 0) text << "duration = " << e.duration << "\n";
  if (e.value != 0) text << "value = " << e.value << "\n";
  if (!e.call.empty()) text << "call = \"" << e.call << "\"\n";
  return text.str();
}

class FaultSystem : public RunningSystem {
 protected:
  static constexpr int kBridges = 4;

  void start_weights() {
    const Urgent urgent;
    server_ = start_tool("palp-sim-server", Vendor::cyclone, {kHere + "four_tools.toml", "--backend", "cpu"});
  }
  std::string file(const std::string& name, int device) const { return folder_ / (name + std::to_string(device)); }
  // The device profile of this bridge.
  std::string profile(int device, const std::string& safety, const std::string& more = "") const {
    std::string name = file("profile", device) + ".toml";
    write_text(name, "name = \"test\"\n" + std::string(kFlightLimits) + "[safety]\n" + safety + "\n" + more);
    return name;
  }
  // A machine that is busy is late, which is a row of its own: the other rows are judged without it.
  inline static const std::string kNeverLate = "overrun_ms = 0\nlate_ticks = 0";

  void start_bridge_of(int device, std::vector<std::string> arguments) {
    const std::vector<std::string> usual{
        "--device-number", std::to_string(device),  "--log",       file("flight", device) + ".csv",
        "--summary",       file("summary", device), "--self-test", "0"};
    arguments.insert(arguments.end(), usual.begin(), usual.end());
    std::vector<std::string> command{kBin + "palp-haptic-bridge", "--domain", std::to_string(domain_)};
    command.insert(command.end(), arguments.begin(), arguments.end());
    bridges_[static_cast<std::size_t>(device)] = std::make_unique<ChildProcess>(command, file("bridge", device));
  }
  // With the driver of the Virtuose, before a simulated one of quick relays.
  void start_arm(int device, const std::vector<ArmEvent>& events, const std::string& safety = kNeverLate,
                 const std::string& script = "") {
    // a busy machine may take a second to begin, and must see the hand open first
    std::string text = "grip_at = 1.1\nrelay_delay = 0.1\nlog = \"calls" + std::to_string(device) + "\"\n" + script;
    for (const ArmEvent& e : events) text += text_of(e);
    const std::string arm = file("arm", device) + ".toml";
    write_text(arm, text);
    const std::string mine =
        profile(device, safety, "[workspace]\nreference = \"relative\"\n[virtuose]\nrelay_time = 0.15\n");
    const std::string library = PALP_LIB_DIR "/libvirtuose_sim.so";
    start_bridge_of(device, {"--device", "virtuose", "--library", library, "--address", arm, "--profile", mine});
  }
  void start_simulated(int device) { start_bridge_of(device, {"--profile", profile(device, kNeverLate)}); }

  ChildProcess& bridge(int device) { return *bridges_[static_cast<std::size_t>(device)]; }
  std::string said_by(int device) const { return text_of(file("bridge", device)); }
  std::string said_by_all() const {
    std::string all = said();
    for (int i = 0; i < kBridges; ++i)
      if (std::filesystem::exists(file("bridge", i))) all += said_by(i);
    return all;
  }
  static std::string name_of(int device) { return "haptic_bridge " + std::to_string(device); }

  // The hand carries most of the weight.
  bool carries(Watcher& watcher, int device, double least = 3) {
    return watcher.sees(
        [&] { return watcher.says(name_of(device), "engaged") && watcher.metric(name_of(device), "force_n") > least; });
  }
  // When the simulated arm of this bridge was opened, on the clock of the flight log; 0: it tells none.
  std::int64_t opened_ns(int device) const {
    std::istringstream words(text_of(file("calls", device)));
    std::string zero, opened, at;
    std::int64_t t = 0;
    words >> zero >> opened >> at >> t;
    return opened == "opened" ? t : 0;
  }
  // When the simulated arm was first asked for this, [s] since it was opened; NaN: never.
  double time_of_call(int device, const std::string& call) const {
    std::istringstream calls(text_of(file("calls", device)));
    for (std::string line; std::getline(calls, line);)
      if (line.find(call) != std::string::npos) return std::stod(line);
    return std::nan("");
  }
  Flight flight(int device) const { return flight_of(file("flight", device) + ".csv"); }

  std::array<std::unique_ptr<ChildProcess>, kBridges> bridges_;
};

// Adds to the row how long after t the wrench was safe, where force was felt at t. Allowed: by the tick that begins
// next, and so many more; a late machine begins it later, by what the log says.
inline void add_same_tick(RowTimes& row, const Flight& flight, std::int64_t t_ns, int more_ticks = 0) {
  const std::size_t next = tick_at(flight, t_ns);
  if (next == 0 || next + static_cast<std::size_t>(more_ticks) >= flight.size()) return;
  // a tick under way at t may have seen it already
  const std::size_t last = next >= 2 ? next - 2 : 0;
  if (flight[last].felt() < 0.5) return;
  std::size_t safe = next - 1;
  while (safe < flight.size() && !flight[safe].safe()) ++safe;
  ASSERT_LT(safe, flight.size());
  double allowed = 1 + more_ticks;
  for (std::size_t i = next; i <= next + static_cast<std::size_t>(more_ticks); ++i) allowed += flight[i].late_ms;
  row.add(std::max(0.0, ms_between(t_ns, flight[safe].t_ns)), allowed);
}

}  // namespace palp::test
