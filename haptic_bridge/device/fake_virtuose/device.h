// One connection to the simulated Virtuose: its clock, its watchdog, the errors that its script asks for and the log of
// all calls.
#pragma once

#include <chrono>
#include <fstream>
#include <string>

#include "haptic_bridge/device/fake_virtuose/arm.h"

namespace palp::fake {

class Device {
 public:
  explicit Device(const Script& script);

  // Runs one call of the library: lets time pass, then either ends it with the error that the script or the watchdog
  // wants, or does the work, which returns an error code. Logs it, keeps the code, returns 0 or -1.
  template <class Work>
  int run(const char* name, const std::string& arguments, bool reads_pose, Work&& work) {
    int code = begin(name, reads_pose);
    if (code == kVirtNoError) code = work(arm);
    return end(name, arguments, code);
  }
  int error() const { return error_; }

  // Notes in the log what a careful client would not do.
  void remark(const std::string& text);
  // The watchdog's: a command has come.
  void refresh() { t_command_ = arm.time(); }
  // A pose as the script wants it shown.
  void show(const Pose& pose, float* out) const;

  Arm arm;
  float time_step = 1e-3F, timeout = 1, force_factor = 1, speed_factor = 1;
  Pose base_frame{0, 0, 0, 0, 0, 0, 1}, observation_frame{0, 0, 0, 0, 0, 0, 1};
  int indexing = kVirtIndexAll;
  bool watchdog = true;
  const Script script;

 private:
  int begin(const char* name, bool reads_pose);
  int end(const char* name, const std::string& arguments, int code);
  int injected(const char* name) const;
  bool stall(const char* name);

  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  double t_lock_step_ = 0;
  double t_command_ = 0;
  bool dropped_ = false;
  int error_ = kVirtNoError;
  std::ofstream log_;
};

}  // namespace palp::fake
