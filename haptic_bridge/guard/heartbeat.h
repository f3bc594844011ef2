// One word between the loop's thread and the supervisor's process: the loop says that it lives, and finds out there
// that it was taken for dead and the arm's power was taken.
#pragma once

#include <atomic>
#include <cstdint>

namespace palp {

// In memory that both processes share. Each of its calls is one atomic exchange: no lock, no system call.
class Heartbeat {
 public:
  // The loop's, once a tick, at now_ns > 0. False: since the last beat the supervisor has taken the loop for dead.
  bool beat(std::int64_t now_ns) noexcept { return word_.exchange(now_ns, std::memory_order_relaxed) != kTaken; }
  // The loop's, after its last tick: its silence is no hang from here on. False: as above.
  bool rest() noexcept { return word_.exchange(0, std::memory_order_relaxed) != kTaken; }

  // The supervisor's. True, and the loop will hear of it at its next beat, when the last one is older than hang_ns.
  // A loop that beats in this very moment is alive: it is one or the other for both sides.
  bool take_if_silent(std::int64_t now_ns, std::int64_t hang_ns) noexcept {
    std::int64_t last = word_.load(std::memory_order_relaxed);
    return last > 0 && now_ns - last > hang_ns &&
           word_.compare_exchange_strong(last, kTaken, std::memory_order_relaxed);
  }

 private:
  static constexpr std::int64_t kTaken = -1;

  std::atomic<std::int64_t> word_{0};  // time of the last tick; 0: the loop does not run
  static_assert(std::atomic<std::int64_t>::is_always_lock_free);
};

}  // namespace palp
