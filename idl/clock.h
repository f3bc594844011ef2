// The clock that all of palp's time stamps are read from.
#pragma once

#include <cerrno>
#include <ctime>

#include <cstdint>

namespace palp {

// Returns the CLOCK_MONOTONIC of this host [ns]. No allocation, no lock; safe in a real-time thread.
inline std::int64_t now_ns() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

// Converts a time or a duration that is not negative [ns].
inline timespec to_timespec(std::int64_t ns) { return {ns / 1'000'000'000, ns % 1'000'000'000}; }

// Sleeps until now_ns() is t_ns, through signals; returns at once where that is past. Safe in a real-time thread.
inline void sleep_until(std::int64_t t_ns) noexcept {
  const timespec t = to_timespec(t_ns);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

}  // namespace palp
