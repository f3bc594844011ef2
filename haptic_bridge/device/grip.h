// The dead-man switch of a device that has none: open at first, closed by and by, and opened and closed again by a hand
// that sees that the loop waits for it.
#pragma once

#include <cstdint>

#include "haptic_bridge/loop/loop_state.h"

namespace palp {

class Grip {
 public:
  static constexpr std::int64_t kOpenNs = 100'000'000;

  // Once a tick. True: the hand holds the handle.
  bool holds(std::int64_t now_ns) noexcept {
    if (t_closed_ns_ < 0 || regrip_) t_closed_ns_ = now_ns + kOpenNs;
    regrip_ = false;
    return now_ns >= t_closed_ns_;
  }
  void show(LoopState state) noexcept { regrip_ = state == LoopState::locked; }

 private:
  std::int64_t t_closed_ns_ = -1;
  bool regrip_ = false;
};

}  // namespace palp
