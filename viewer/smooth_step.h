// A fade without a kink at either end.
#pragma once

#include <algorithm>

namespace palp {

// Returns 0 where x is at `from` or before it, 1 where it is at `to` or beyond. from: another number than to.
inline float smooth_step(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

}  // namespace palp
