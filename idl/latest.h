// Newest-value mailbox between two threads: the writer never waits for the reader nor the reader for the writer.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace palp {

// One thread writes, one thread reads. Both sides are wait-free, allocate nothing and take no lock: fit for a real-time
// thread. Three buffers: the writer owns one, the reader owns one, and the third changes hands by one atomic exchange.
template <class T>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>, "a mailbox copies its value byte by byte");

 public:
  // Writer's side. A value that was not taken yet is replaced.
  void put(const T& value) {
    slots_[back_].value = value;
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }

  // Reader's side. True and the newest value if one was put since the last call; else false and out is untouched.
  bool take(T& out) {
    if (!(middle_.load(std::memory_order_relaxed) & kFresh)) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    out = slots_[front_].value;
    return true;
  }

 private:
  static constexpr std::uint8_t kIndex = 3;
  static constexpr std::uint8_t kFresh = 4;
  // a cache line of its own, so that writer and reader do not slow each other
  struct alignas(64) Slot {
    T value{};
  };

  std::array<Slot, 3> slots_;
  alignas(64) std::uint8_t back_ = 0;                 // the writer's
  alignas(64) std::atomic<std::uint8_t> middle_ = 1;  // between them, with kFresh if not yet taken
  alignas(64) std::uint8_t front_ = 2;                // the reader's
};

}  // namespace palp
