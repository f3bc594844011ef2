// The C interface of VirtuoseAPI, by its documented names and argument types, before a simulated arm. One arm, one
// connection. What the arm is and does stands in a TOML file: the address given to virtOpen when it ends in ".toml",
// else the file that the environment variable PALP_FAKE_VIRTUOSE names, else nothing goes wrong.
#include "haptic_bridge/device/fake_virtuose/library.h"

#include <cstdlib>
#include <cstring>

namespace {

using palp::VirtContext;
using namespace palp::fake;  // the C interface stands outside of every namespace

palp::fake::Script script_for(const std::string& address) {
  const std::string ending = ".toml";
  const char* variable = std::getenv("PALP_FAKE_VIRTUOSE");
  const bool is_file =
      address.size() > ending.size() && address.compare(address.size() - ending.size(), ending.size(), ending) == 0;
  if (is_file) return palp::fake::read_script(address);
  return variable && *variable ? palp::fake::read_script(variable) : palp::fake::Script{};
}

// Takes a setting that a careful client makes before the command type.
template <class Work>
int set_early(const char* name, VirtContext context, const std::string& arguments, bool valid, Work&& work) {
  return call(name, context, arguments, [&](Arm& arm) {
    if (!valid) return palp::kVirtIncorrectValue;
    if (arm.mode != palp::kVirtNoCommand) device().remark(std::string(name) + " after virtSetCommandType");
    work();
    return palp::kVirtNoError;
  });
}

int set_frame(const char* name, VirtContext context, const float* frame, Pose Device::*target) {
  return set_early(name, context, text_of(frame, 7), is_pose(frame), [&] {
    std::copy(frame, frame + 7, (device().*target).begin());
    if (!std::equal(frame, frame + 7, Pose{0, 0, 0, 0, 0, 0, 1}.begin()))
      device().remark(std::string(name) + ": frames are not simulated");
  });
}

}  // namespace

Connection& palp::fake::connection() {
  static Connection c;
  return c;
}

PALP_EXPORT int virtAPIVersion(int* major, int* minor) {
  try {
    const palp::fake::Script script = script_for("");
    *major = script.major_version;
    *minor = script.minor_version;
    return 0;
  } catch (...) {
    *major = *minor = 4;  // virtOpen tells what is wrong with the script
    return 0;
  }
}

PALP_EXPORT VirtContext virtOpen(const char* address) {
  Connection& c = connection();
  const std::lock_guard<std::mutex> lock(c.mutex);
  try {
    if (c.device) {
      c.error = palp::kVirtAlreadyCalled;
      return nullptr;
    }
    const palp::fake::Script script = script_for(address ? address : "");
    for (const auto& event : script.events) {
      if (event.kind != palp::fake::EventKind::error || event.call != "virtOpen") continue;
      c.error = static_cast<int>(event.value);
      return nullptr;
    }
    c.device = std::make_unique<Device>(script);
    return c.device.get();
  } catch (const std::exception& error) {
    c.open_failure = error.what();
    c.error = kSyntaxError;
    return nullptr;
  }
}

PALP_EXPORT int virtClose(VirtContext context) {
  end_periodic_loop();
  const int result = call("virtClose", context, [](Arm& arm) {
    if (arm.power_wanted) device().remark("virtClose with the power on");
    return palp::kVirtNoError;
  });
  Connection& c = connection();
  const std::lock_guard<std::mutex> lock(c.mutex);
  if (c.device && context == c.device.get()) c.device.reset();  // an error does not keep it open
  return result;
}

PALP_EXPORT int virtGetErrorCode(VirtContext context) {
  Connection& c = connection();
  const std::lock_guard<std::mutex> lock(c.mutex);
  return c.device && context == c.device.get() ? c.device->error() : c.error;
}

PALP_EXPORT char* virtGetErrorMessage(int code) {
  static char text[512];
  const char* found = "unknown error";
  switch (code) {
    case palp::kVirtNoError:
      found = "no error";
      break;
    case kOutOfMemory:
      found = "out of memory";
      break;
    case palp::kVirtCommunication:
      found = "the controller does not answer";
      break;
    case palp::kVirtInvalidContext:
      found = "there is no such connection";
      break;
    case palp::kVirtTimeOut:
      found = "the controller answered too late";
      break;
    case palp::kVirtNotImplemented:
      found = "not simulated";
      break;
    case palp::kVirtNotAvailable:
      found = "the value is not available";
      break;
    case palp::kVirtIncorrectValue:
      found = "a value is out of range";
      break;
    case kSyntaxError:
      found = connection().open_failure.c_str();
      break;
    case palp::kVirtHardware:
      found = "the hardware has failed";
      break;
    case palp::kVirtDiscontinuity:
      found = "the position has jumped";
      break;
    case palp::kVirtWrongMode:
      found = "not in this command type";
      break;
    case palp::kVirtCallTime:
      found = "not at this time";
      break;
    case palp::kVirtVersion:
      found = "library and controller do not fit";
      break;
    case palp::kVirtAlreadyCalled:
      found = "this has been done already";
      break;
    default:
      break;
  }
  std::strncpy(text, found, sizeof text - 1);
  return text;
}

PALP_EXPORT int virtGetControlerVersion(VirtContext context, int* major, int* minor) {
  return call("virtGetControlerVersion", context, [&](Arm&) {
    *major = device().script.major_version;
    *minor = device().script.minor_version;
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtGetDeviceID(VirtContext context, int* type, int* serial) {
  return call("virtGetDeviceID", context, [&](Arm&) {
    *type = device().script.device_type;
    *serial = device().script.serial;
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtSetTimeoutValue(VirtContext context, float seconds) {
  return set_early("virtSetTimeoutValue", context, text_of(&seconds, 1), seconds > 0 && seconds < 1e6F,
                   [&] { device().timeout = seconds; });
}

PALP_EXPORT int virtSetIndexingMode(VirtContext context, int type) {
  return set_early("virtSetIndexingMode", context, std::to_string(type) + ' ', type >= 0 && type <= 7,
                   [&] { device().indexing = type; });
}

PALP_EXPORT int virtSetForceFactor(VirtContext context, float factor) {
  return set_early("virtSetForceFactor", context, text_of(&factor, 1), factor > 0 && factor < 1e3F, [&] {
    device().force_factor = factor;
    if (factor != 1) device().remark("a force factor other than 1 is not simulated");
  });
}

PALP_EXPORT int virtSetSpeedFactor(VirtContext context, float factor) {
  return set_early("virtSetSpeedFactor", context, text_of(&factor, 1), factor > 0 && factor < 1e3F, [&] {
    device().speed_factor = factor;
    if (factor != 1) device().remark("a speed factor other than 1 is not simulated");
  });
}

PALP_EXPORT int virtSetTimeStep(VirtContext context, float step) {
  return set_early("virtSetTimeStep", context, text_of(&step, 1), step > 0 && step < 1,
                   [&] { device().time_step = step; });
}

PALP_EXPORT int virtSetBaseFrame(VirtContext context, float* frame) {
  return set_frame("virtSetBaseFrame", context, frame, &Device::base_frame);
}

PALP_EXPORT int virtSetObservationFrame(VirtContext context, float* frame) {
  return set_frame("virtSetObservationFrame", context, frame, &Device::observation_frame);
}

PALP_EXPORT int virtSetObservationFrameSpeed(VirtContext context, float* speed) {
  return call("virtSetObservationFrameSpeed", context, text_of(speed, 6),
              [&](Arm&) { return finite(speed, 6) ? palp::kVirtNoError : palp::kVirtIncorrectValue; });
}

PALP_EXPORT int virtSetCommandType(VirtContext context, int type) {
  return call("virtSetCommandType", context, std::to_string(type) + ' ', [&](Arm& arm) {
    if (type != palp::kVirtNoCommand && type != palp::kVirtImpedance && type != palp::kVirtMechanism)
      return palp::kVirtNotImplemented;
    if (arm.power_wanted) device().remark("virtSetCommandType with the power on");
    arm.mode = type;
    device().refresh();
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtSaturateTorque(VirtContext context, float force, float torque) {
  const float values[] = {force, torque};
  return call("virtSaturateTorque", context, text_of(values, 2), [&](Arm& arm) {
    if (!finite(values, 2) || force < 0 || torque < 0) return palp::kVirtIncorrectValue;
    arm.force_limit = static_cast<double>(force);
    arm.torque_limit = static_cast<double>(torque);
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtEnableForceFeedback(VirtContext context, int enable) {
  return call("virtEnableForceFeedback", context, std::to_string(enable) + ' ', [&](Arm& arm) {
    arm.feedback = enable != 0;
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtSetPowerOn(VirtContext context, int power) {
  return call("virtSetPowerOn", context, std::to_string(power) + ' ', [&](Arm& arm) {
    if (power && arm.mode == palp::kVirtNoCommand) device().remark("virtSetPowerOn before virtSetCommandType");
    arm.power_wanted = power != 0;
    return palp::kVirtNoError;
  });
}

PALP_EXPORT int virtDisableControlConnexion(VirtContext context, int disable) {
  return call("virtDisableControlConnexion", context, std::to_string(disable) + ' ', [&](Arm&) {
    device().watchdog = disable == 0;
    return palp::kVirtNoError;
  });
}
