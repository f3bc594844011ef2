// How the server tells people how it fares: a status a few times a second, and warnings about what they can mend. A
// thread of its own reads gauges that the simulation's thread writes.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "idl/bus.h"
#include "idl/histogram.h"
#include "idl/roster.h"
#include "sim_server/bus_links.h"
#include "sim_server/messages_from_state.h"

namespace palp {

// Written by the simulation's thread, read by any.
struct Gauges {
  Histogram step_time, handover;
  std::atomic<ServerState> state{ServerState::running};
  std::atomic<double> sim_time{0}, real_time_factor{0}, max_speed{0}, max_compression{0}, kinetic_energy{0},
      gone_mass{0}, expected_speed{0}, mean_compression{0}, expected_compression{0};
  std::atomic<bool> doubtful{false};  // Health::doubt says why
  std::atomic<std::uint64_t> steps{0}, slow_steps{0}, outside{0};
};

// The settings that decide how much a step costs.
struct Effort {
  std::size_t particles = 0;
  Accuracy accuracy = Accuracy::balanced;
  bool paced = true;       // false: it runs as fast as it can and is never slow
  double period_us = 1e3;  // simulated time of a step [us]
};

// Returns what to do about a simulation that runs at this real-time factor, as one sentence. step_us: its median step.
std::string advice_for_slow(double real_time_factor, double step_us, const Effort& effort);

class ServerStatusReporter {
 public:
  // All must outlive it. Starts the thread.
  ServerStatusReporter(Bus& bus, const Gauges& gauges, const Effort& effort, HapticLink& haptic,
                       const FrameLink& frames, ControlLink& control);
  // Publishes the last status, state "ended", and leaves readers the time to take it.
  ~ServerStatusReporter();

 private:
  void run(const std::stop_token& ended);
  void publish(const std::string& state, const std::string& text, double real_time_factor);
  std::string find_trouble();
  std::string find_other_server();
  std::string find_second_bridge();
  std::string find_slowness(double real_time_factor);
  void warn_once(const std::string& sentence, std::uint64_t about, std::uint64_t& warned_about);

  const Gauges& gauges_;
  const Effort effort_;
  HapticLink& haptic_;
  const FrameLink& frames_;
  ControlLink& control_;
  const std::uint64_t own_session_;
  std::unique_ptr<Reader<Status>> statuses_;
  Roster roster_;
  std::uint64_t warned_server_ = 0, warned_bridge_ = 0, warned_slow_ = 0;  // whom people were warned of, by session
  std::uint64_t last_slow_steps_ = 0;
  int slow_in_a_row_ = 0;  // reports
  std::jthread thread_;    // last: starts when the rest is there
};

}  // namespace palp
