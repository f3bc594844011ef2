// Newest-value mailboxes between two threads: the writer never waits for the reader nor the reader for the writer.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace palp {

// Three buffers: the writer owns one, the reader owns one, and the third changes hands by one atomic exchange. One
// thread writes, one thread reads. The mailbox itself is wait-free and allocates nothing.
template <class T>
class TripleBuffer {
 public:
  // Writer's side: the buffer to fill. It holds what some earlier value left there.
  T& back() { return slots_[back_].value; }
  // Writer's side: hands back() over. A value that was not taken yet is replaced; false if there was such a value.
  bool publish() {
    const std::uint8_t was = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel);
    back_ = was & kIndex;
    return !(was & kFresh);
  }

  // Reader's side: makes the newest value front(). False if nothing was published since the last call.
  bool update() {
    if (!(middle_.load(std::memory_order_relaxed) & kFresh)) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  // Reader's side: the value of the last update().
  T& front() { return slots_[front_].value; }

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

// The same for small values, by copy. Both sides are wait-free, allocate nothing and take no lock: fit for a real-time
// thread.
template <class T>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>, "a copy of the value must not allocate");

 public:
  // Writer's side. A value that was not taken yet is replaced.
  void put(const T& value) {
    buffer_.back() = value;
    buffer_.publish();
  }
  // Reader's side. True and the newest value if one was put since the last call; else false and out is untouched.
  bool take(T& out) {
    if (!buffer_.update()) return false;
    out = buffer_.front();
    return true;
  }

 private:
  TripleBuffer<T> buffer_;
};

}  // namespace palp
