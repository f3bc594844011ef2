// Functions of the C interface that palp's driver does not call and other clients do: what was set, and the loop that
// calls a function of the client at its period.
#include <atomic>
#include <chrono>
#include <thread>

#include "haptic_bridge/device/fake_virtuose/library.h"

namespace {

using palp::VirtContext;
using namespace palp::fake;  // the C interface stands outside of every namespace

constexpr int kNoPeriodicFunction = 14;

int read_value(const char* name, VirtContext context, float* out, float Device::*value) {
  return call(name, context, [&](Arm&) {
    *out = device().*value;
    return palp::kVirtNoError;
  });
}

int read_frame(const char* name, VirtContext context, float* out, Pose Device::*frame) {
  return call(name, context, [&](Arm&) {
    const Pose& f = device().*frame;
    std::copy(f.begin(), f.end(), out);
    return palp::kVirtNoError;
  });
}

int attach(const char* name, VirtContext context, float mass, const float* inertia) {
  return call(name, context, text_of(&mass, 1) + text_of(inertia, 9), [&](Arm& arm) {
    if (arm.mode != palp::kVirtMechanism) return palp::kVirtWrongMode;
    if (arm.attached) return palp::kVirtAlreadyCalled;
    if (!(mass > 0 && std::isfinite(mass)) || !finite(inertia, 9)) return palp::kVirtIncorrectValue;
    // gains that a controller might choose for such an object: the arm's own are Haption's secret
    const float k = std::min(1000.0F, 1000.0F * mass), r = 0.01F;
    const float b = std::sqrt(k * mass);
    arm.stiffness = {r * k, r * k, r * k, k, k, k};
    arm.damping = {r * b, r * b, r * b, b, b, b};
    arm.attach();
    return palp::kVirtNoError;
  });
}

// The client's own function, called at its period by a thread of this library.
struct PeriodicLoop {
  void (*function)(VirtContext, void*) = nullptr;
  const float* period = nullptr;  // the client's; it must live as long as the loop
  void* argument = nullptr;
  std::thread thread;
  std::atomic<bool> stop{false};

  void run(VirtContext context) {
    auto next = std::chrono::steady_clock::now();
    while (!stop) {
      const auto step = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<float>(*period));
      next += step;
      function(context, argument);
      const auto now = std::chrono::steady_clock::now();
      if (now > next + step) next = now;  // never in a burst
      std::this_thread::sleep_until(next);
    }
  }
  void end() {
    stop = true;
    if (thread.joinable()) thread.join();
  }
};

// A call that reads one value.
template <class T, class Get>
int give(const char* name, VirtContext context, T* out, const Get& get) {
  return call(name, context, [&](Arm& arm) {
    *out = get(arm);
    return palp::kVirtNoError;
  });
}

PeriodicLoop& loop() {
  static PeriodicLoop l;
  return l;
}

}  // namespace

void palp::fake::end_periodic_loop() { loop().end(); }

PALP_EXPORT int virtGetForceFactor(VirtContext context, float* factor) {
  return read_value("virtGetForceFactor", context, factor, &Device::force_factor);
}
PALP_EXPORT int virtGetSpeedFactor(VirtContext context, float* factor) {
  return read_value("virtGetSpeedFactor", context, factor, &Device::speed_factor);
}
PALP_EXPORT int virtGetTimeStep(VirtContext context, float* step) {
  return read_value("virtGetTimeStep", context, step, &Device::time_step);
}
PALP_EXPORT int virtGetTimeoutValue(VirtContext context, float* seconds) {
  return read_value("virtGetTimeoutValue", context, seconds, &Device::timeout);
}
PALP_EXPORT int virtGetBaseFrame(VirtContext context, float* frame) {
  return read_frame("virtGetBaseFrame", context, frame, &Device::base_frame);
}
PALP_EXPORT int virtGetObservationFrame(VirtContext context, float* frame) {
  return read_frame("virtGetObservationFrame", context, frame, &Device::observation_frame);
}

PALP_EXPORT int virtGetIndexingMode(VirtContext context, int* type) {
  return give("virtGetIndexingMode", context, type, [](Arm&) { return device().indexing; });
}

PALP_EXPORT int virtGetCommandType(VirtContext context, int* type) {
  return give("virtGetCommandType", context, type, [](Arm& arm) { return arm.mode; });
}

PALP_EXPORT int virtGetNbAxes(VirtContext context, int* axes) {
  return give("virtGetNbAxes", context, axes, [](Arm&) { return 6; });
}

PALP_EXPORT int virtGetError(VirtContext context, int* error) {
  return give("virtGetError", context, error, [](Arm&) { return device().error(); });
}

// Ticks of a microsecond since the state was measured.
PALP_EXPORT int virtGetTimeLastUpdate(VirtContext context, unsigned* ticks) {
  return give("virtGetTimeLastUpdate", context, ticks,
              [](Arm& arm) { return static_cast<unsigned>(1e6 * (arm.time() - arm.measured_at())); });
}

PALP_EXPORT int virtAddForce(VirtContext context, float* force) {
  return call("virtAddForce", context, text_of(force, 6), [&](Arm& arm) {
    if (arm.mode != palp::kVirtImpedance && arm.mode != palp::kVirtMechanism) return palp::kVirtWrongMode;
    if (!finite(force, 6)) return palp::kVirtIncorrectValue;
    Vector more;
    std::copy(force, force + 6, more.begin());
    arm.add(more);
    device().refresh();
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtAttachVO(VirtContext context, float mass, float* inertia) {
  return attach("virtAttachVO", context, mass, inertia);
}
PALP_EXPORT int virtAttachVOAvatar(VirtContext context, float mass, float* inertia) {
  return attach("virtAttachVOAvatar", context, mass, inertia);
}
PALP_EXPORT int virtDetachVOAvatar(VirtContext context) { return virtDetachVO(context); }

PALP_EXPORT int virtGetSimulationStiffness(VirtContext context, float* stiffness) {
  return call("virtGetSimulationStiffness", context, [&](Arm& arm) {
    std::copy(arm.stiffness.begin(), arm.stiffness.end(), stiffness);
    return palp::kVirtNoError;
  });
}
PALP_EXPORT int virtGetSimulationDamping(VirtContext context, float* damping) {
  return call("virtGetSimulationDamping", context, [&](Arm& arm) {
    std::copy(arm.damping.begin(), arm.damping.end(), damping);
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtSetPeriodicFunction(VirtContext context, void (*function)(VirtContext, void*), float* period,
                                        void* argument) {
  return call("virtSetPeriodicFunction", context, [&](Arm&) {
    if (!function || !period || !(*period > 0)) return palp::kVirtIncorrectValue;
    if (loop().thread.joinable()) return palp::kVirtAlreadyCalled;
    loop().function = function;
    loop().period = period;
    loop().argument = argument;
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtStartLoop(VirtContext context) {
  return call("virtStartLoop", context, [&](Arm&) -> int {
    if (!loop().function) return kNoPeriodicFunction;
    if (loop().thread.joinable()) return palp::kVirtAlreadyCalled;
    loop().stop = false;
    loop().thread = std::thread([context] { loop().run(context); });
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtStopLoop(VirtContext context) {
  const int result = call("virtStopLoop", context,
                          [](Arm&) { return loop().thread.joinable() ? palp::kVirtNoError : palp::kVirtCallTime; });
  loop().end();
  return result;
}
