// Times in fixed logarithmic bins, at most 3 % wide, or 0.4 %: one thread adds, any thread may read while it does.
// add: no allocation, no lock, no throw.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>

namespace palp {

// kSubBits: each octave has 2^kSubBits bins.
template <unsigned kSubBits>
class HistogramOf {
 public:
  // Negative times count as zero.
  void add(std::int64_t time_ns) {
    const std::uint64_t t = time_ns > 0 ? static_cast<std::uint64_t>(time_ns) : 0;
    bump(bins_[bin(t)]);
    bump(count_);
    if (t > max_.load(std::memory_order_relaxed)) max_.store(t, std::memory_order_relaxed);
  }
  std::uint64_t count() const { return count_.load(std::memory_order_relaxed); }
  double max_us() const { return static_cast<double>(max_.load(std::memory_order_relaxed)) * 1e-3; }

  // The time [us] that a share (0..1) of all entries does not exceed, rounded up to its bin's end. 0 when empty.
  double quantile_us(double share) const {
    const std::uint64_t total = count();
    if (total == 0) return 0;
    const double wanted = share * static_cast<double>(total);
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBins; ++i) {
      seen += bins_[i].load(std::memory_order_relaxed);
      if (seen > 0 && static_cast<double>(seen) >= wanted) return std::min(end_of(i) * 1e-3, max_us());
    }
    return max_us();
  }

 private:
  static constexpr std::size_t kBins = (64 - kSubBits + 1) << kSubBits;

  static std::size_t bin(std::uint64_t t) {
    const unsigned width = static_cast<unsigned>(std::bit_width(t));
    if (width <= kSubBits + 1) return static_cast<std::size_t>(t);
    const unsigned shift = width - kSubBits - 1;
    return (static_cast<std::size_t>(shift) << kSubBits) + static_cast<std::size_t>(t >> shift);
  }
  static double end_of(std::size_t i) {
    if (i < (std::size_t{2} << kSubBits)) return static_cast<double>(i);
    const std::size_t shift = (i >> kSubBits) - 1;
    const double mantissa =
        static_cast<double>((i & ((std::size_t{1} << kSubBits) - 1)) + (std::size_t{1} << kSubBits));
    return (mantissa + 1) * static_cast<double>(std::uint64_t{1} << shift);
  }
  static void bump(std::atomic<std::uint64_t>& n) {
    n.store(n.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  std::array<std::atomic<std::uint64_t>, kBins> bins_{};
  std::atomic<std::uint64_t> count_{0};
  std::atomic<std::uint64_t> max_{0};
};
using Histogram = HistogramOf<5>;      // 15 KB
using FineHistogram = HistogramOf<8>;  // 117 KB

}  // namespace palp
