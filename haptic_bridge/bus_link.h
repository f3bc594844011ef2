// The two threads between the loop's mailboxes and the bus. Each owns its reader or writer, so neither waits for the
// other nor for the loop:
//   sender: wakes right after each tick and publishes the device sample. The wake is a futex call in the loop's thread
//     (about 2 us, never blocks); polling instead would cost half a millisecond of latency or a core.
//   receiver: waits on the proxy samples and puts the newest one of this device into the mailbox. Of several servers it
//     holds on to one, so that no force is ever mixed of two.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "haptic_bridge/guard/realtime.h"
#include "haptic_bridge/number_watch.h"
#include "haptic_bridge/run.h"
#include "idl/bus.h"
#include "idl/histogram.h"
#include "idl/session_hold.h"

namespace palp {

class BusLink {
 public:
  // ports must outlive the link. realtime: of the two threads (core and priority; refusals are ignored).
  BusLink(Bus& bus, std::uint32_t device, const RealtimeOptions& realtime, LoopPorts& ports);
  ~BusLink();  // stops
  BusLink(const BusLink&) = delete;
  BusLink& operator=(const BusLink&) = delete;

  // Before start only: the newest proxy sample of this device that has arrived. False if none.
  bool newest_proxy(ProxySample& out);
  void start();
  void stop();

  // Any thread.
  DropCounts drops() const;
  int servers() const { return servers_.load(std::memory_order_relaxed); }  // matched writers of proxy samples
  // The server whose samples reach the loop, and one that is passed over meanwhile; by session, 0: none.
  std::uint64_t server_session() const { return server_session_.load(std::memory_order_relaxed); }
  std::uint64_t rival_server() const { return rival_server_.load(std::memory_order_relaxed); }
  // Returns the session of another live bridge that the server answers instead of this one; 0: none.
  std::uint64_t number_holder() const { return number_holder_.load(std::memory_order_relaxed); }
  std::uint64_t received() const { return received_.load(std::memory_order_relaxed); }
  std::uint64_t sent() const { return sent_.load(std::memory_order_relaxed); }
  std::uint64_t send_failures() const { return send_failures_.load(std::memory_order_relaxed); }
  const Histogram& send_time() const { return send_time_; }  // pose read -> publish has returned
  // Empty, or why one of the threads gave up (read after failed() was true).
  bool failed() const { return failed_.load(std::memory_order_acquire); }
  const std::string& failure() const { return failure_; }

 private:
  void send_all();
  void receive_all();
  bool take_newest(IncomingProxy& out);
  void note_reader();
  void guarded(void (BusLink::*work)());

  std::uint32_t device_;
  RealtimeOptions realtime_;
  LoopPorts& ports_;
  std::unique_ptr<Writer<DeviceSample>> writer_;
  std::unique_ptr<Reader<ProxySample>> reader_;
  std::vector<Received<ProxySample>> batch_;
  std::vector<std::uint64_t> heard_;
  SessionHold hold_{kServerHold};
  NumberWatch number_watch_;
  std::thread sender_, receiver_;
  std::atomic<bool> stop_{false};

  std::array<std::atomic<std::uint64_t>, 4> drops_{};  // the first four of DropCounts
  std::atomic<std::uint32_t> other_version_{0};
  std::int64_t t_noted_ns_ = 0;  // the receiver's
  std::atomic<int> servers_{0};
  std::atomic<std::uint64_t> server_session_{0}, rival_server_{0}, number_holder_{0};
  std::atomic<std::uint64_t> received_{0}, sent_{0}, send_failures_{0};
  Histogram send_time_;
  std::atomic<bool> failing_{false}, failed_{false};
  std::string failure_;
};

}  // namespace palp
