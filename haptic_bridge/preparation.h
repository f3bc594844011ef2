// Makes ready what the bridge needs before its loop runs: the device's request, the supervisor, room for its files, a
// test of this machine.
#pragma once

#include <memory>
#include <string>

#include "haptic_bridge/guard/supervisor.h"
#include "haptic_bridge/log/rerun.h"
#include "haptic_bridge/options.h"

namespace palp {

// The log and the loop's configuration, where another process sees them.
struct SharedLog {
  FlightLog log;
  SharedArray<LoopConfig> config{1};
};

std::size_t logged_ticks(const BridgeOptions& o);

// Reads everything that the user gave, before anything is opened, and looks for what the device needs. Throws
// ConfigError or std::runtime_error.
DeviceRequest make_request(const BridgeOptions& o);

// Reserves room for the bridge's files, so that one that cannot be written is told of before the run, not at its end.
// Throws ConfigError.
std::unique_ptr<LogRoom> room_for_files(const BridgeOptions& o);

// If this process dies, a device with motors is powered off from outside, and the log is written there. The request and
// the log must outlive it; call it before there is any thread.
std::unique_ptr<Supervisor> supervise(const BridgeOptions& o, const DeviceRequest& request, const SharedLog& shared);

// On a machine that is often late a device with motors gets little force. Returns what was found, as one phrase.
std::string test_machine(const BridgeOptions& o, LoopConfig& config);

}  // namespace palp
