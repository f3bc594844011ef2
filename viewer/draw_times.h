// How long pictures took to draw.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace palp {

// Keeps the newest ten thousand.
class DrawTimes {
 public:
  void add(double seconds) {
    if (newest_.size() < kMost) newest_.push_back(0);
    newest_[count_++ % kMost] = seconds;
  }
  std::size_t count() const { return count_; }
  // The time [ms] that this share of the newest pictures took at most; 0 without any.
  double share_ms(double share) const {
    if (newest_.empty()) return 0;
    std::vector<double> sorted = newest_;
    std::ranges::sort(sorted);
    return 1e3 * sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  }

 private:
  static constexpr std::size_t kMost = 10'000;
  std::vector<double> newest_;  // [s]
  std::size_t count_ = 0;
};

}  // namespace palp
