// Makes what the bridge tells of itself: metrics for its Status and its summary, sentences for its states.
#pragma once

#include <string>
#include <vector>

#include "config/json_file.h"
#include "haptic_bridge/bus_link.h"
#include "haptic_bridge/run.h"
#include "idl/messages.h"

namespace palp {

// Returns the figures of a run so far; rate_hz is given by who measures it. Any thread.
std::vector<Metric> bridge_metrics(const LoopReport& report, const LoopPorts& ports, const BusLink& link,
                                   double rate_hz);

// Returns one sentence about what is not as it should be, or empty: a peer with another protocol version first, then a
// server that follows another bridge, then the state.
std::string bridge_trouble(const LoopReport& report, const BusLink& link);

// The summary of a run, printed at its end and written beside the flight log.
struct Summary {
  std::string process;  // "haptic_bridge 0"
  std::string device;
  std::string scheduling;  // RealtimeReport::line
  std::string bus;         // "cyclone, domain 0"
  std::string log;         // path, or why there is none
  std::string state;
  std::string trouble;  // empty: healthy
  double rate_hz = 0;
  std::vector<Metric> metrics;
};
std::string to_text(const Summary& summary);
Json json_of(const Summary& summary);

}  // namespace palp
