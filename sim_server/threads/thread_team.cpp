#include "sim_server/threads/thread_team.h"

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <utility>

#include "sim_server/threads/float_mode.h"

namespace palp {
namespace {

// How long a thread looks for what it waits for before it sleeps [s]. To sleep and be woken takes as long as a small
// loop, and while a thread of a step sleeps, something modest that computes takes its processor for a whole slice of
// the scheduler's, some milliseconds: so within a step threads only sleep when one of them has lost its processor.
constexpr double kPatience = 1e-3, kPatienceBetweenSteps = 2e-5;
constexpr int kFirstPause = 16;  // calls of adapt() for which helpers sleep when they are first found to be in the way
constexpr int kLongestPause = 4096;
// The share of the time gained that may be lost by waiting. At 1 helpers and caller are as fast as the caller alone,
// but not as even.
constexpr double kBearable = 0.5;
constexpr double kFading = 0.9;  // of the sums at each call of adapt()
constexpr std::uint64_t kChunks = 0xffffffffu;

void pause_briefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

int niceness() { return getpriority(PRIO_PROCESS, 0); }

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// Returns whether done() becomes true while this thread's patience() [s] lasts.
template <class Done, class Patience>
bool comes_soon(const Done& done, const Patience& patience) {
  constexpr int kPausesALook = 32;  // at the clock
  const double begin = now_s();
  while (true) {
    for (int k = 0; k < kPausesALook; ++k) {
      if (done()) return true;
      pause_briefly();
    }
    if (now_s() - begin > patience()) return false;
  }
}

}  // namespace

int usable_processors() {
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));  // of more than a set has room for
}

int available_threads() {
  const char* asked = std::getenv("OMP_NUM_THREADS");
  const int threads = asked != nullptr ? std::atoi(asked) : 0;
  return std::clamp(threads > 0 ? threads : usable_processors(), 1, 1024);
}

ThreadTeam::ThreadTeam(int threads) : invited_(threads - 1), niceness_(niceness()), next_pause_(kFirstPause) {
  for (int k = 0; k + 1 < threads; ++k) helpers_.emplace_back(&ThreadTeam::help, this, k);
}

ThreadTeam::~ThreadTeam() {
  stop_ = true;
  invited_ = threads();  // those that sleep because they are not invited wake, too
  invited_.notify_all();
  ++loop_;
  loop_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
}

void ThreadTeam::run(std::uint64_t chunk) {
  const std::size_t begin = chunk * job_.chunk;
  set_float_mode(job_.mode);  // a helper computes as the caller does
  try {
    job_.call(job_.work, begin, std::min(job_.n, begin + job_.chunk));
  } catch (...) {
    const std::lock_guard lock(failure_mutex_);
    if (!failure_) failure_ = std::current_exception();
  }
}

bool ThreadTeam::run_chunk() {
  std::uint64_t left = left_.load(std::memory_order_acquire);
  do {
    if ((left & kChunks) == 0) return false;
  } while (!left_.compare_exchange_weak(left, left - 1, std::memory_order_acq_rel));
  run((left & kChunks) - 1);
  return true;
}

void ThreadTeam::help(int index) {
  int own_niceness = niceness();
  while (true) {
    if (const int wanted = niceness_.load(std::memory_order_relaxed); wanted != own_niceness) {
      own_niceness = wanted;
      setpriority(PRIO_PROCESS, 0, wanted);  // where that is allowed
    }
    const int invited = invited_.load(std::memory_order_acquire);
    if (index >= invited) {
      invited_.wait(invited, std::memory_order_acquire);
      continue;
    }
    const std::uint32_t loop = loop_.load(std::memory_order_acquire);
    if (stop_) return;
    while (run_chunk()) {
      helped_.fetch_add(1, std::memory_order_release);
      helped_.notify_one();
    }
    const bool soon =
        comes_soon([&] { return loop_.load(std::memory_order_relaxed) != loop; },
                   [&] { return within_step_.load(std::memory_order_relaxed) ? kPatience : kPatienceBetweenSteps; });
    if (!soon) loop_.wait(loop, std::memory_order_acquire);
  }
}

void ThreadTeam::share_out(const Job& job) {
  const std::size_t chunks = (job.n + job.chunk - 1) / job.chunk;
  if (chunks <= 1 || invited_.load(std::memory_order_relaxed) == 0) {
    for (std::size_t begin = 0; begin < job.n; begin += job.chunk)
      job.call(job.work, begin, std::min(job.n, begin + job.chunk));
    return;
  }
  const double begin = now_s();
  job_ = job;
  job_.mode = float_mode();
  helped_.store(0, std::memory_order_relaxed);
  const std::uint64_t number = loop_.load(std::memory_order_relaxed) + 1u;
  within_step_.store(true, std::memory_order_relaxed);
  left_.store(number << 32 | chunks, std::memory_order_release);
  loop_.store(static_cast<std::uint32_t>(number), std::memory_order_release);
  loop_.notify_all();
  std::uint32_t own = 0;
  while (run_chunk()) ++own;
  const double done = now_s();
  const auto others = static_cast<std::uint32_t>(chunks) - own;
  if (helped_.load(std::memory_order_acquire) != others) {
    wait_for_helpers(others);
    if (own > 0) lost_ += now_s() - done;  // else this thread was kept from running itself
  }
  if (own > 0) gained_ += (done - begin) * others / own;
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void ThreadTeam::wait_for_helpers(std::uint32_t chunks) {
  const auto all_done = [&] { return helped_.load(std::memory_order_acquire) == chunks; };
  if (comes_soon(all_done, [] { return kPatience; })) return;
  for (std::uint32_t done = helped_.load(std::memory_order_acquire); done != chunks;
       done = helped_.load(std::memory_order_acquire))
    helped_.wait(done, std::memory_order_acquire);
}

void ThreadTeam::adapt() {
  const int all = static_cast<int>(helpers_.size()), invited = invited_.load(std::memory_order_relaxed);
  if (all == 0) return;
  within_step_.store(false, std::memory_order_relaxed);
  niceness_.store(niceness(), std::memory_order_relaxed);
  if (invited > 0 && lost_ > kBearable * gained_) {
    invited_.store(invited / 2, std::memory_order_release);
    pause_ = next_pause_;
    next_pause_ = std::min(2 * next_pause_, kLongestPause);
    gained_ = lost_ = 0;
    good_ = 0;
  } else if (invited < all && --pause_ <= 0) {
    invited_.store(std::min(all, std::max(1, 2 * invited)), std::memory_order_release);
    invited_.notify_all();
    pause_ = kFirstPause;
  } else if (++good_ % kLongestPause == 0) {
    next_pause_ = std::max(next_pause_ / 2, kFirstPause);
  }
  gained_ *= kFading;
  lost_ *= kFading;
}

}  // namespace palp
