// How the wrench fades with the age of the data that it is made of. No allocation, no lock, no throw.
#pragma once

#include <cstdint>

namespace palp {

// The ages of data at which the wrench changes. Until fade_start the newest local model is used as it is; then it fades
// into plain damping, which is all that is left at fade_end; from zero_at on the wrench is zero.
struct StaleTimes {
  std::int64_t fade_start_ns = 20'000'000;
  std::int64_t fade_end_ns = 60'000'000;
  std::int64_t zero_at_ns = 95'000'000;  // below the 100 ms that are promised: ticks and samples may be late
};

// Returns the weight of the local model at this age, 1..0.
inline double stale_scale(std::int64_t age_ns, const StaleTimes& t) {
  if (age_ns <= t.fade_start_ns) return 1;
  if (age_ns >= t.fade_end_ns) return 0;
  return static_cast<double>(t.fade_end_ns - age_ns) / static_cast<double>(t.fade_end_ns - t.fade_start_ns);
}

}  // namespace palp
