// Writes the flight log when the process dies of a programming error: a failed assertion, an uncaught exception, a bad
// address, a bad instruction. What the ring holds is worth more than a clean death.
#pragma once

#include <string>

#include "haptic_bridge/log/flight_log.h"

namespace palp {

// While one lives, SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT write the log to the path, and the run beside it
// (rerun.h), and then kill the process as they would have. Writing allocates, which a signal handler may not safely do;
// should it hang, the process dies after five seconds all the same. At most one at a time; log and config must outlive
// it.
class CrashLog {
 public:
  CrashLog(const FlightLog& log, const LoopConfig& config, const std::string& path);
  ~CrashLog();
  CrashLog(const CrashLog&) = delete;
  CrashLog& operator=(const CrashLog&) = delete;
};

}  // namespace palp
