// A Haption Virtuose through VirtuoseAPI. One tick makes the calls listed at read and write; whether the library
// answers them from memory or asks the controller each time is its secret, so they are few.
#pragma once

#include <cstdint>
#include <string>

#include "haptic_bridge/device/driver.h"
#include "haptic_bridge/device/virtuose/frames.h"
#include "haptic_bridge/device/virtuose/session.h"
#include "haptic_bridge/loop/haptic_device.h"

namespace palp {

// The trouble that ended the use of the arm. Plain data: the loop's thread fills it, others read it after the loop has
// ended.
struct VirtuoseTrouble {
  const char* call = nullptr;  // that failed; null: none did, what says it
  int code = 0;                // of the call
  const char* what = nullptr;
  unsigned bits = 0;  // of alarm or failure
};

class VirtuoseDevice final : public HapticDevice {
 public:
  // Connects to the arm; it is without force until the loop sends some. start: where in the world the handle is taken
  // to be at the first reading; the hand moves it from there. Throws as VirtuoseSession does.
  VirtuoseDevice(const VirtuoseSetup& setup, const RigidState& start);

  const DeviceInfo& info() const noexcept override { return info_; }

  // Every tick: pose, speed, dead-man, power, shift. In turn, one a tick: emergency stop (which takes the power with
  // it), bounds, alarms, failures, buttons. The pose is the avatar's: shifting moves the arm and not the tool.
  // False: a call failed, or the arm showed no pose. Errors of the link are waited out, by the loop's count; any other
  // error is for good: force and power are taken off at once and every later read is false.
  // No allocation, no lock of ours.
  bool read(std::int64_t now_ns, DeviceReading& out) noexcept override;
  // One call, or two in mode mechanism. If it fails, zero force is tried.
  bool write(const Wrench<double>& wrench) noexcept override;
  void release() noexcept override { session_.make_safe(); }
  void show(LoopState state) noexcept override { state_ = state; }

  // One sentence about the last failure, or empty. Not while a loop runs.
  std::string trouble() const override;

 private:
  bool passed(const char* call, int result) noexcept;
  void break_down(const VirtuoseTrouble& trouble) noexcept;
  bool read_motion(DeviceReading& out) noexcept;
  bool read_switches(std::int64_t now_ns, DeviceReading& out) noexcept;
  bool read_in_turn() noexcept;
  bool stands_still(std::int64_t now_ns, const DeviceReading& reading) noexcept;
  bool write_force(const Wrench<double>& wrench) noexcept;
  bool write_target(const Wrench<double>& wrench) noexcept;
  void find_buttons() noexcept;

  // The call's name goes with its result.
  template <class... A, class... B>
  bool passes(const VirtCall<A...>& call, B... arguments) noexcept {
    return passed(call.name, call.function(session_.context(), arguments...));
  }

  VirtuoseSetup setup_;
  VirtuoseSession session_;
  ArmFrame frame_;
  DeviceInfo info_;

  ArmPose pose_{};
  ArmVector speed_{};
  bool placed_ = false;
  std::int64_t t_moved_ns_ = 0;  // when the pose last changed
  RigidState state_in_world_;
  bool good_reading_ = false;

  bool dead_man_ = false, power_ = false, chain_closed_ = false;
  bool was_stopped_ = false;     // by the emergency stop, and no power since
  std::int64_t t_power_ns_ = 0;  // since when the power is on
  unsigned bounds_ = 0, alarms_ = 0;
  std::uint32_t buttons_ = 0, has_button_ = 0;
  int turn_ = 0;

  LoopState state_ = LoopState::waiting;
  bool feedback_ = false;  // in mode mechanism: whether the controller's coupling is on
  bool broken_ = false;
  VirtuoseTrouble trouble_;
};

// Its setup is a VirtuoseSetup (tables [virtuose] and [axes] of a profile).
Driver virtuose_driver();

}  // namespace palp
