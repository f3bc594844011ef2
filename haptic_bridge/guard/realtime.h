// Asks the operating system for what a 1 kHz loop needs: priority, locked memory, a core of its own, absolute sleep.
// Everything is tried, nothing is required, and one line says what was granted.
#pragma once

#include <cstdint>
#include <string>

#include <semaphore.h>

namespace palp {

struct RealtimeOptions {
  int priority = 75;  // SCHED_FIFO, 1..98; 0: ordinary scheduling
  int cpu = -1;       // core to stay on; -1: any
  bool lock_memory = true;
};

struct RealtimeReport {
  bool fifo = false;
  int priority = 0;
  bool memory_locked = false;
  int cpu = -1;
  std::string trouble;  // what was refused and why; empty: nothing
  // "SCHED_FIFO 75, memory locked, any core of 2, kernel 6.12 PREEMPT_DYNAMIC"
  std::string line() const;
};

// Locks the memory of the process, present and future. Once, early, from any thread.
// Never fails: report.memory_locked and report.trouble say what came of it.
void lock_memory(const RealtimeOptions& options, RealtimeReport& report);
// Makes the calling thread a real-time one, on its core, and touches its stack. Never fails, as above.
void make_realtime(const RealtimeOptions& options, RealtimeReport& report);

// While an object of this class lives, the calling thread and all threads that it starts have this priority, where that
// is allowed: those of a library keep it. 0: nothing changes.
class PriorityHere {
 public:
  explicit PriorityHere(int priority);
  ~PriorityHere();
  PriorityHere(const PriorityHere&) = delete;
  PriorityHere& operator=(const PriorityHere&) = delete;

 private:
  bool raised_ = false;
};

// How late a loop of this period would be on this machine now, measured with nothing to do.
struct Lateness {
  double seconds = 0;  // of the test; 0: none was made
  double p50_us = 0, p999_us = 0, max_us = 0;
};
// Measures in a thread of its own, with the loop's priority and core, for so many seconds.
Lateness measure_lateness(const RealtimeOptions& options, std::int64_t period_ns, double seconds);
// A machine that is later than this in one of a thousand ticks is not to be trusted with an arm's full force [us].
inline constexpr double kTrustedLateness = 500;

// The loop's time. No allocation, no lock, no throw.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual std::int64_t now_ns() noexcept = 0;
  virtual void sleep_until(std::int64_t t_ns) noexcept = 0;
  // CPU time that the calling thread has used; 0: not measured. Always a system call, so not for every tick.
  virtual std::int64_t cpu_ns() noexcept { return 0; }
};

// CLOCK_MONOTONIC, absolute sleep.
class RealClock final : public Clock {
 public:
  std::int64_t now_ns() noexcept override;
  void sleep_until(std::int64_t t_ns) noexcept override;
  std::int64_t cpu_ns() noexcept override;
};

// Time that moves only when slept: exact, repeatable, faster than real.
class LockStepClock final : public Clock {
 public:
  explicit LockStepClock(std::int64_t start_ns = 1'000'000'000) : now_(start_ns) {}
  std::int64_t now_ns() noexcept override { return now_; }
  void sleep_until(std::int64_t t_ns) noexcept override {
    if (t_ns > now_) now_ = t_ns;
  }

 private:
  std::int64_t now_;
};

// Wakes a waiting thread. wake never blocks: it is an atomic increment, and a futex call only while somebody waits.
class Wakeup {
 public:
  Wakeup() { sem_init(&semaphore_, 0, 0); }
  ~Wakeup() { sem_destroy(&semaphore_); }
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;

  void wake() noexcept { sem_post(&semaphore_); }
  // Waits for wake or until the time is up. Wakes that piled up count as one. True if there was one.
  bool wait_for(std::int64_t timeout_ns) noexcept;

 private:
  sem_t semaphore_;
};

}  // namespace palp
