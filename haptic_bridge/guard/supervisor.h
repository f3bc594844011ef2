// A process of its own that powers the arm off when the bridge dies or its loop hangs: an arm's own watchdog may take
// two seconds (VirtuoseAPI). It hears the bridge's end by a closed pipe, whatever ended it, and the loop's by its
// heartbeat. After a death it saves what the bridge cannot save any more.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include <sys/types.h>

#include "haptic_bridge/guard/heartbeat.h"

namespace palp {

class Supervisor {
 public:
  // Forks: call it before any thread is started. power_off runs in the other process, once, when the bridge has died or
  // no heartbeat came for hang_ns after the first; a loop that goes on after that hears of it by its heartbeat. Empty
  // where there is nothing to power off. save runs there, too, after power_off and only when the bridge has died, be it
  // after a hang; it returns what it did, for people. Throws std::runtime_error with one sentence.
  explicit Supervisor(const std::function<void()>& power_off, const std::function<std::string()>& save = {},
                      std::int64_t hang_ns = 50'000'000);
  // The arm has been left without force: the supervisor ends without powering off what is off.
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  // The loop's, shared with the other process.
  Heartbeat& heartbeat() { return *heartbeat_; }
  pid_t pid() const { return pid_; }
  // False: it has died or was stopped, and guards nothing any more. Asks the system and does not wait; SIGCHLD tells
  // when to ask. For one thread.
  bool alive();

 private:
  Heartbeat* heartbeat_ = nullptr;
  int pipe_ = -1;
  pid_t pid_ = -1;
  bool lost_ = false, reaped_ = false;
};

}  // namespace palp
