// Writes the flight log when the process dies of a programming error: a failed assertion, an uncaught exception, a bad
// address, a bad instruction. What the ring holds is worth more than a clean death.
#pragma once

#include <string>
#include <thread>

#include "haptic_bridge/log/flight_log.h"

namespace palp {

// While one lives, SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT write the log to the path, and the run beside it
// (rerun.h), and then kill the process as they would have. A thread that sleeps until then does it, since the one that
// dies may hold a lock of the allocator's or of a stream's; should it hang all the same, the process dies after five
// seconds. At most one at a time; log and config must outlive it. Throws std::system_error where the system has no
// pipes left.
class CrashLog {
 public:
  CrashLog(const FlightLog& log, const LoopConfig& config, const std::string& path);
  ~CrashLog();
  CrashLog(const CrashLog&) = delete;
  CrashLog& operator=(const CrashLog&) = delete;

 private:
  std::thread writer_;
};

}  // namespace palp
