// The parts that all functions of the C interface share: the one connection, and how each call is made.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <string>

#include "haptic_bridge/device/fake_virtuose/device.h"

#define PALP_EXPORT extern "C" __attribute__((visibility("default")))

// The driver's own list declares what it calls, so a definition here with other arguments does not compile.
#define PALP_DECLARE(name, symbol, ...) PALP_EXPORT int symbol(palp::VirtContext __VA_OPT__(, ) __VA_ARGS__);
PALP_VIRTUOSE_CALLS(PALP_DECLARE)
#undef PALP_DECLARE

namespace palp::fake {

inline constexpr int kOutOfMemory = 1, kSyntaxError = 10;

struct Connection {
  std::mutex mutex;  // clients may call from any thread
  std::unique_ptr<Device> device;
  int error = kVirtNoError;  // of calls without a valid context
  std::string open_failure;
};
Connection& connection();
// The device that the connection is open to; call it while one is.
inline Device& device() { return *connection().device; }
void end_periodic_loop();  // waits for it

template <class Work>
int call(const char* name, VirtContext context, const std::string& arguments, Work&& work, bool reads_pose = false) {
  Connection& c = connection();
  const std::lock_guard<std::mutex> lock(c.mutex);
  try {
    if (!c.device || context != c.device.get()) {
      c.error = kVirtInvalidContext;
      return -1;
    }
    return c.device->run(name, arguments, reads_pose, work);
  } catch (...) {
    c.error = kOutOfMemory;
    return -1;
  }
}

template <class Work>
int call(const char* name, VirtContext context, Work&& work) {
  return call(name, context, "", work);
}

inline std::string text_of(const float* values, int n) {
  std::string text;
  for (int i = 0; i < n; ++i) text += std::to_string(values[i]) + ' ';
  return text;
}

inline bool finite(const float* values, int n) {
  return std::all_of(values, values + n, [](float v) { return std::isfinite(v); });
}
inline bool is_pose(const float* p) {
  return finite(p, 7) && std::abs(p[3] * p[3] + p[4] * p[4] + p[5] * p[5] + p[6] * p[6] - 1) < 1e-2F;
}

}  // namespace palp::fake
