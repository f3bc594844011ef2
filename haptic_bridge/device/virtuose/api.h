// The part of Haption's VirtuoseAPI (version 4) that palp uses: names, argument types and numbers as its public
// documentation gives them. The library itself belongs to Haption, is not part of palp and is opened at run time.
// SI units, float; a pose is x y z qx qy qz qw, a speed or force linear then angular. Every call returns 0, or
// something else after which virtGetErrorCode tells what went wrong.
#pragma once

#include <memory>
#include <string>

namespace palp {

using VirtContext = void*;

inline constexpr int kVirtuoseMajorVersion = 4;

enum VirtCommand : int { kVirtNoCommand = 0, kVirtImpedance = 3, kVirtMechanism = 5 };
enum VirtIndexing : int { kVirtIndexAll = 0, kVirtIndexTranslation = 1, kVirtIndexNone = 2 };

enum VirtError : int {
  kVirtNoError = 0,
  kVirtCommunication = 2,
  kVirtInvalidContext = 3,
  kVirtTimeOut = 6,
  kVirtNotImplemented = 7,
  kVirtNotAvailable = 8,
  kVirtIncorrectValue = 9,
  kVirtHardware = 11,
  kVirtDiscontinuity = 12,
  kVirtWrongMode = 17,
  kVirtCallTime = 19,
  kVirtVersion = 20,
  kVirtAlreadyCalled = 22,
};

// The bits that virtGetAlarm returns; virtIsInBounds uses the bits below kVirtOverheat.
enum VirtAlarm : unsigned {
  kVirtOverheat = 0x4000,        // a motor is too hot: the controller reduces the force by itself
  kVirtSaturated = 0x8000,       // the motor currents are at their maximum
  kVirtErrorPosition = 0x40000,  // the measured position is wrong
};

// A function of the library that takes the context first.
template <class... A>
struct VirtCall {
  const char* name;
  int (*function)(VirtContext, A...) = nullptr;
};

// X(our name, the library's, arguments after the context...)
#define PALP_VIRTUOSE_CALLS(X)                                   \
  X(close, virtClose)                                            \
  X(controller_version, virtGetControlerVersion, int*, int*)     \
  X(device_id, virtGetDeviceID, int*, int*)                      \
  X(set_timeout, virtSetTimeoutValue, float)                     \
  X(set_indexing, virtSetIndexingMode, int)                      \
  X(set_force_factor, virtSetForceFactor, float)                 \
  X(set_speed_factor, virtSetSpeedFactor, float)                 \
  X(set_time_step, virtSetTimeStep, float)                       \
  X(set_base_frame, virtSetBaseFrame, float*)                    \
  X(set_observation_frame, virtSetObservationFrame, float*)      \
  X(set_observation_speed, virtSetObservationFrameSpeed, float*) \
  X(set_command_type, virtSetCommandType, int)                   \
  X(saturate_torque, virtSaturateTorque, float, float)           \
  X(enable_feedback, virtEnableForceFeedback, int)               \
  X(set_power_on, virtSetPowerOn, int)                           \
  X(get_avatar, virtGetAvatarPosition, float*)                   \
  X(get_speed, virtGetSpeed, float*)                             \
  X(get_dead_man, virtGetDeadMan, int*)                          \
  X(get_power_on, virtGetPowerOn, int*)                          \
  X(get_emergency_stop, virtGetEmergencyStop, int*)              \
  X(is_shifted, virtIsInShiftPosition, int*)                     \
  X(is_in_bounds, virtIsInBounds, unsigned*)                     \
  X(get_alarm, virtGetAlarm, unsigned*)                          \
  X(get_failure, virtGetFailure, unsigned*)                      \
  X(get_button, virtGetButton, int, int*)                        \
  X(set_force, virtSetForce, float*)                             \
  X(set_position, virtSetPosition, float*)                       \
  X(set_speed, virtSetSpeed, float*)                             \
  X(attach_qsvo, virtAttachQSVO, float*, float*)                 \
  X(detach_vo, virtDetachVO)

// The functions, found by name. Calls are made by one thread at a time.
class VirtuoseApi {
 public:
  // Opens the shared library: a path, or a name that the system's loader looks for. Throws ConfigError with one
  // sentence when there is none, when it is no library for this machine, when it lacks a function, or when its version
  // is another than kVirtuoseMajorVersion.
  explicit VirtuoseApi(const std::string& library);

  // The library's own words for an error code, or "unknown error".
  const char* message(int code) const noexcept;
  const std::string& version() const { return version_; }  // "4.4"

#define PALP_DECLARE(name, symbol, ...) VirtCall<__VA_ARGS__> name{#symbol};
  PALP_VIRTUOSE_CALLS(PALP_DECLARE)
#undef PALP_DECLARE
  VirtContext (*open)(const char* address) = nullptr;
  int (*error_code)(VirtContext) = nullptr;

 private:
  struct Unload {
    void operator()(void* handle) const noexcept;
  };
  void check_version();

  std::string path_, version_;
  std::unique_ptr<void, Unload> handle_;
  char* (*error_message_)(int) = nullptr;
};

}  // namespace palp
