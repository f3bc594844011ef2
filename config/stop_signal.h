// How every program of palp is asked to end: by SIGINT or SIGTERM, of which it hears where it looks or waits, and then
// ends in its own order. System calls in progress return early (no SA_RESTART), so that a wait for the keyboard ends,
// too.
#pragma once

#include <poll.h>
#include <pthread.h>

#include <atomic>
#include <csignal>
#include <cstdint>

#include "idl/clock.h"

namespace palp {

// The number of the last signal that asked this process to end; 0: none has.
inline std::atomic<int>& stop_signal() {
  static_assert(std::atomic<int>::is_always_lock_free);
  static std::atomic<int> signal{0};
  return signal;
}

inline bool stop_asked() { return stop_signal().load(std::memory_order_relaxed) != 0; }

enum class SecondSignal { is_ignored, ends_at_once };

// The time within which signals count as one [ns]: timeout(1) sends its own to the process and to its group.
inline constexpr std::int64_t kOneSignal = 300'000'000;

// Before this call a signal simply ends the process. second: what a signal does that comes after kOneSignal.
inline void catch_stop_signals(SecondSignal second = SecondSignal::is_ignored) {
  static std::atomic<std::int64_t> first{0};
  static_assert(std::atomic<std::int64_t>::is_always_lock_free);
  stop_signal();
  first = 0;
  struct sigaction action {};
  if (second == SecondSignal::ends_at_once)
    action.sa_handler = [](int number) {
      const std::int64_t now = now_ns();
      if (!stop_asked()) first = now;
      stop_signal().store(number, std::memory_order_relaxed);
      if (now - first <= kOneSignal) return;
      std::signal(number, SIG_DFL);
      std::raise(number);
    };
  else
    action.sa_handler = [](int number) { stop_signal().store(number, std::memory_order_relaxed); };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

inline sigset_t stop_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGCHLD);
  return set;
}

// No thread that is started from now on is interrupted by these signals; only wait_for_stop takes them. A child that
// ends wakes it early.
inline void take_stop_signals_in_wait() {
  struct sigaction action {};
  action.sa_handler = [](int) {};
  sigaction(SIGCHLD, &action, nullptr);  // whoever started this process may have left it ignored
  const sigset_t set = stop_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

// Waits for a signal, or for a child to end, but no longer than the timeout. Returns whether the process is asked to
// end.
inline bool wait_for_stop(std::int64_t timeout_ns) {
  if (stop_asked()) return true;
  const timespec timeout = to_timespec(timeout_ns);
  sigset_t mask;
  pthread_sigmask(SIG_BLOCK, nullptr, &mask);
  for (const int number : {SIGINT, SIGTERM, SIGCHLD}) sigdelset(&mask, number);
  ppoll(nullptr, 0, &timeout, &mask);
  return stop_asked();
}

}  // namespace palp
