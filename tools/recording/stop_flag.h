// SIGINT and SIGTERM ask the program to end; it looks at stop_asked() and ends in its own order.
#pragma once

#include <atomic>
#include <csignal>

namespace palp {

inline std::atomic<bool>& stop_flag() {
  static std::atomic<bool> flag{false};
  return flag;
}
inline bool stop_asked() { return stop_flag().load(std::memory_order_relaxed); }

// System calls in progress return early (no SA_RESTART), so that a wait for the keyboard ends too.
inline void catch_stop_signals() {
  static_assert(std::atomic<bool>::is_always_lock_free);
  stop_flag();
  struct sigaction action {};
  action.sa_handler = [](int) { stop_flag().store(true, std::memory_order_relaxed); };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace palp
