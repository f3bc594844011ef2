// The functions of the C interface that a loop calls: state, switches, commands.
#include "haptic_bridge/device/fake_virtuose/library.h"

namespace {

using palp::VirtContext;
using namespace palp::fake;  // the C interface stands outside of every namespace

template <class T>
int read(const char* name, VirtContext context, T* out, T (*value)(const Device&)) {
  return call(name, context, [&](Arm&) {
    *out = value(device());
    return palp::kVirtNoError;
  });
}

int read_pose(const char* name, VirtContext context, float* out, bool physical) {
  return call(
      name, context, "",
      [&](Arm& arm) {
        device().show(physical ? arm.physical() : arm.avatar(), out);
        return palp::kVirtNoError;
      },
      true);
}

int read_speed(const char* name, VirtContext context, float* out) {
  return call(name, context, [&](Arm& arm) {
    std::copy(arm.speed().begin(), arm.speed().end(), out);
    return palp::kVirtNoError;
  });
}

Vector vector_at(const float* values) {
  Vector v;
  std::copy(values, values + 6, v.begin());
  return v;
}

}  // namespace

PALP_EXPORT int virtGetAvatarPosition(VirtContext context, float* pose) {
  return read_pose("virtGetAvatarPosition", context, pose, false);
}
PALP_EXPORT int virtGetPosition(VirtContext context, float* pose) {
  return read_pose("virtGetPosition", context, pose, false);
}
PALP_EXPORT int virtGetPhysicalPosition(VirtContext context, float* pose) {
  return read_pose("virtGetPhysicalPosition", context, pose, true);
}
PALP_EXPORT int virtGetSpeed(VirtContext context, float* speed) { return read_speed("virtGetSpeed", context, speed); }
PALP_EXPORT int virtGetPhysicalSpeed(VirtContext context, float* speed) {
  return read_speed("virtGetPhysicalSpeed", context, speed);
}

PALP_EXPORT int virtGetDeadMan(VirtContext context, int* on) {
  return read<int>("virtGetDeadMan", context, on, [](const Device& d) { return int{d.arm.dead_man()}; });
}
PALP_EXPORT int virtGetPowerOn(VirtContext context, int* on) {
  return read<int>("virtGetPowerOn", context, on, [](const Device& d) { return int{d.arm.powered()}; });
}
PALP_EXPORT int virtGetEmergencyStop(VirtContext context, int* closed) {
  return read<int>("virtGetEmergencyStop", context, closed, [](const Device& d) { return int{d.arm.chain_closed()}; });
}
PALP_EXPORT int virtIsInShiftPosition(VirtContext context, int* shifted) {
  return read<int>("virtIsInShiftPosition", context, shifted, [](const Device& d) { return int{d.arm.shifted()}; });
}
PALP_EXPORT int virtIsInBounds(VirtContext context, unsigned* bits) {
  return read<unsigned>("virtIsInBounds", context, bits, [](const Device& d) { return d.arm.bounds(); });
}
PALP_EXPORT int virtGetAlarm(VirtContext context, unsigned* bits) {
  return read<unsigned>("virtGetAlarm", context, bits, [](const Device& d) { return d.arm.alarms(); });
}
PALP_EXPORT int virtGetFailure(VirtContext context, unsigned* bits) {
  return read<unsigned>("virtGetFailure", context, bits, [](const Device& d) {
    double value = 0;
    return d.arm.is_on(palp::fake::EventKind::failure, &value) ? palp::fake::bits_of(value) : 0u;
  });
}

PALP_EXPORT int virtGetButton(VirtContext context, int number, int* pressed) {
  return call("virtGetButton", context, std::to_string(number) + ' ', [&](Arm& arm) {
    if (number < 0 || number > 2) return palp::kVirtIncorrectValue;
    double value = -1;
    *pressed = arm.is_on(palp::fake::EventKind::button, &value) && static_cast<int>(value) == number;
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtGetForce(VirtContext context, float* force) {
  return call("virtGetForce", context, [&](Arm& arm) {
    std::copy(arm.rendered().begin(), arm.rendered().end(), force);
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtSetForce(VirtContext context, float* force) {
  return call("virtSetForce", context, text_of(force, 6), [&](Arm& arm) {
    if (arm.mode != palp::kVirtImpedance) return palp::kVirtWrongMode;
    if (!finite(force, 6)) return palp::kVirtIncorrectValue;
    arm.send(vector_at(force));
    device().refresh();
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtSetPosition(VirtContext context, float* pose) {
  return call("virtSetPosition", context, text_of(pose, 7), [&](Arm& arm) {
    if (arm.mode != palp::kVirtMechanism) return palp::kVirtWrongMode;
    if (!is_pose(pose)) return palp::kVirtIncorrectValue;
    Pose target;
    std::copy(pose, pose + 7, target.begin());
    arm.send_target(&target, nullptr);
    device().refresh();
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtSetSpeed(VirtContext context, float* speed) {
  return call("virtSetSpeed", context, text_of(speed, 6), [&](Arm& arm) {
    if (arm.mode != palp::kVirtMechanism) return palp::kVirtWrongMode;
    if (!finite(speed, 6)) return palp::kVirtIncorrectValue;
    const Vector target = vector_at(speed);
    arm.send_target(nullptr, &target);
    device().refresh();
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtAttachQSVO(VirtContext context, float* stiffness, float* damping) {
  return call("virtAttachQSVO", context, text_of(stiffness, 6) + text_of(damping, 6), [&](Arm& arm) {
    if (arm.mode != palp::kVirtMechanism) return palp::kVirtWrongMode;
    if (arm.attached) return palp::kVirtAlreadyCalled;
    if (!finite(stiffness, 6) || !finite(damping, 6)) return palp::kVirtIncorrectValue;
    arm.stiffness = vector_at(stiffness);
    arm.damping = vector_at(damping);
    arm.attach();
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtDetachVO(VirtContext context) {
  return call("virtDetachVO", context, [&](Arm& arm) {
    if (!arm.attached) return palp::kVirtCallTime;
    arm.attached = false;
    return palp::kVirtNoError;
  });
}
