// The newest values of something, in a ring: what plots over time show. Pure.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace palp {

struct TimedValue {
  double time = 0;  // [s]
  double value = 0;
};

// Keeps about the last kSpan seconds, however often values come: those that follow the one before too closely are
// passed over.
class History {
 public:
  static constexpr double kSpan = 10;  // [s]
  static constexpr std::size_t kMost = 640;

  // A value that is not finite is passed over; a time before the newest one begins the history anew.
  void add(double time, double value) {
    if (!std::isfinite(time) || !std::isfinite(value)) return;
    if (count_ > 0 && time < newest().time) count_ = 0;
    if (count_ > 0 && time - newest().time < kSpan / kMost) return;
    ring_[next_] = {time, value};
    next_ = (next_ + 1) % kMost;
    if (count_ < kMost) ++count_;
  }
  void clear() { count_ = 0; }

  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  // i: 0 the oldest .. size() - 1.
  const TimedValue& operator[](std::size_t i) const { return ring_[(next_ + kMost - count_ + i) % kMost]; }
  const TimedValue& newest() const { return (*this)[count_ - 1]; }

 private:
  std::array<TimedValue, kMost> ring_{};
  std::size_t next_ = 0, count_ = 0;
};

}  // namespace palp
