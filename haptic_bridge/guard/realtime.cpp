#include "haptic_bridge/guard/realtime.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <thread>

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/utsname.h>

#include "idl/clock.h"
#include "idl/histogram.h"

namespace palp {

namespace {

constexpr std::size_t kStackToTouch = 256 * 1024;

void add_trouble(RealtimeReport& report, const std::string& what) {
  report.trouble += (report.trouble.empty() ? "" : "; ") + what;
}

// So that the first deep call inside the loop does not fault its pages in.
[[gnu::noinline]] void touch_stack() {
  char stack[kStackToTouch];
  for (std::size_t i = 0; i < kStackToTouch; i += 1024) static_cast<volatile char&>(stack[i]) = 0;
}

std::string kernel_name() {
  utsname name{};
  if (uname(&name) != 0) return "kernel unknown";
  const std::string version = name.version;
  std::string kind = "no preemption model named";
  for (const char* model : {"PREEMPT_RT", "PREEMPT_DYNAMIC", "PREEMPT"}) {
    if (version.find(model) != std::string::npos) {
      kind = model;
      break;
    }
  }
  return std::string("kernel ") + name.release + " " + kind;
}

}  // namespace

std::string RealtimeReport::line() const {
  const std::string cores = std::to_string(std::thread::hardware_concurrency());
  return (fifo ? "SCHED_FIFO " + std::to_string(priority) : std::string("ordinary scheduling")) +
         (memory_locked ? ", memory locked" : ", memory not locked") +
         (cpu >= 0 ? ", core " + std::to_string(cpu) + " of " + cores : ", any core of " + cores) + ", " +
         kernel_name() + (trouble.empty() ? "" : " (" + trouble + ")");
}

void lock_memory(const RealtimeOptions& options, RealtimeReport& report) {
  if (!options.lock_memory) return;
  report.memory_locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (!report.memory_locked)
    add_trouble(report, std::string("locking memory was refused: ") + std::strerror(errno) + ", raise memlock");
}

void make_realtime(const RealtimeOptions& options, RealtimeReport& report) {
  if (options.cpu >= 0) {
    cpu_set_t cores;
    CPU_ZERO(&cores);
    CPU_SET(static_cast<unsigned>(options.cpu) % CPU_SETSIZE, &cores);
    const int error = pthread_setaffinity_np(pthread_self(), sizeof cores, &cores);
    if (error == 0) {
      report.cpu = options.cpu;
    } else {
      add_trouble(report, "core " + std::to_string(options.cpu) + " was refused: " + std::strerror(error));
    }
  }
  if (options.priority > 0) {
    sched_param parameter{};
    parameter.sched_priority = options.priority;
    const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
    report.fifo = error == 0;
    if (report.fifo) {
      report.priority = options.priority;
    } else {
      add_trouble(report, std::string("SCHED_FIFO was refused: ") + std::strerror(error) + ", raise rtprio");
    }
  }
  touch_stack();
}

PriorityHere::PriorityHere(int priority) {
  const sched_param parameter{priority};
  raised_ = priority > 0 && pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter) == 0;
}

PriorityHere::~PriorityHere() {
  const sched_param ordinary{0};
  if (raised_) pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
}

Lateness measure_lateness(const RealtimeOptions& options, std::int64_t period_ns, double seconds) {
  Histogram lateness;
  std::thread([&] {
    RealtimeReport ignored;
    make_realtime(options, ignored);
    RealClock clock;
    std::int64_t deadline = clock.now_ns() + period_ns;
    const std::int64_t end = deadline + std::llround(1e9 * seconds);
    while (deadline < end) {
      clock.sleep_until(deadline);
      const std::int64_t late = clock.now_ns() - deadline;
      lateness.add(late);
      deadline += (1 + late / period_ns) * period_ns;
    }
  }).join();
  return {seconds, lateness.quantile_us(0.5), lateness.quantile_us(0.999), lateness.max_us()};
}

std::int64_t RealClock::now_ns() noexcept { return palp::now_ns(); }

void RealClock::sleep_until(std::int64_t t_ns) noexcept { palp::sleep_until(t_ns); }

std::int64_t RealClock::cpu_ns() noexcept {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec * 1'000'000'000 + t.tv_nsec;
}

bool Wakeup::wait_for(std::int64_t timeout_ns) noexcept {
  const timespec t = to_timespec(now_ns() + timeout_ns);
  int result;
  while ((result = sem_clockwait(&semaphore_, CLOCK_MONOTONIC, &t)) != 0 && errno == EINTR) {
  }
  if (result != 0) return false;
  while (sem_trywait(&semaphore_) == 0) {
  }
  return true;
}

}  // namespace palp
