// Runs the loop's ticks at absolute deadlines, between the two mailboxes that the bus's threads keep.
#pragma once

#include <atomic>
#include <cstdint>

#include "haptic_bridge/guard/heartbeat.h"
#include "haptic_bridge/guard/realtime.h"
#include "haptic_bridge/log/flight_log.h"
#include "haptic_bridge/loop/loop.h"
#include "idl/histogram.h"
#include "idl/latest.h"

namespace palp {

// The data that the loop shares with other threads. Each mailbox has one writer and one reader.
struct LoopPorts {
  Latest<IncomingProxy> incoming;         // written by the bus's receiver
  Latest<DeviceSample> outgoing;          // read by the bus's sender
  Latest<LoopReport> report;              // read by whoever tells people
  Wakeup sample_ready;                    // after each outgoing sample
  std::atomic<std::uint64_t> refused{0};  // samples of the server that the bus found malformed, in all
  Heartbeat* heartbeat = nullptr;         // of each tick; null: nobody looks
  std::atomic<bool> unguarded{false};     // set by whoever finds that the supervisor is lost: the force ends
  Histogram lateness;                     // of each tick behind its deadline
  Histogram age;                          // of the sample in use, in ticks that have one and it is not stale
  Histogram delay;                        // device state read -> first tick that renders its answer, per sample used
  Histogram duration;                     // of each tick, device and mailboxes included, sleep and flight log not
  std::atomic<std::int64_t> cpu_ns{0};    // that the loop's thread used from first to last tick; 0 until it ends
};

// Runs ticks until stop is set, a fault occurs, or max_ticks (0: no end) are done. A tick that is late by whole periods
// skips them and never catches up in a burst. A loop whose heartbeat was taken for dead, or that nobody guards any
// more, ends with a fault in its next tick. Whatever ends it, the device is left without force. No allocation, no lock,
// no throw, no print; system calls: the clock, the device's, and the futex of sample_ready, which does not block.
LoopFault run_loop(HapticLoop& loop, Clock& clock, LoopPorts& ports, FlightLog& log, const std::atomic<bool>& stop,
                   std::uint64_t max_ticks = 0);

}  // namespace palp
