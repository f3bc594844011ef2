#include "haptic_bridge/device/fake_virtuose/device.h"

#include <limits>
#include <thread>

namespace palp::fake {

namespace {
constexpr double kWatchdog = 2;  // without a command for so long the controller drops the connection [s]
}

Device::Device(const Script& s) : arm(s), script(s) {
  if (s.log.empty()) return;
  std::ofstream(s.log).close();  // empties it; a bridge and its supervisor then write to its end
  log_.open(s.log, std::ios::app);
  if (!s.lock_step) log_ << 0 << " opened at " << began_.time_since_epoch().count() << '\n';
}

int Device::begin(const char* name, bool reads_pose) {
  const bool timed_out = stall(name);
  if (script.lock_step) {
    if (reads_pose) t_lock_step_ += time_step;
    arm.advance_to(t_lock_step_);
  } else {
    arm.advance_to(std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count());
  }
  if (watchdog && arm.mode != kVirtNoCommand && arm.time() - t_command_ > kWatchdog) dropped_ = true;
  if (dropped_) {
    arm.cut();
    return kVirtCommunication;
  }
  return timed_out ? kVirtTimeOut : injected(name);
}

// A call that takes as long as the script says. True if that is longer than the client waits.
bool Device::stall(const char* name) {
  for (const Event& event : script.events) {
    if (event.kind != EventKind::slow || !event.holds(arm.time()) || (!event.call.empty() && event.call != name))
      continue;
    const double wait = std::min(event.value, static_cast<double>(timeout));
    if (script.lock_step) {
      t_lock_step_ += wait;
    } else {
      std::this_thread::sleep_for(std::chrono::duration<double>(wait));
    }
    return event.value > static_cast<double>(timeout);
  }
  return false;
}

int Device::injected(const char* name) const {
  for (const Event& event : script.events) {
    if (event.kind == EventKind::error && event.holds(arm.time()) && (event.call.empty() || event.call == name))
      return static_cast<int>(event.value);
  }
  return kVirtNoError;
}

int Device::end(const char* name, const std::string& arguments, int code) {
  if (log_.is_open()) log_ << arm.time() << ' ' << name << ' ' << arguments << "= " << code << '\n';
  if (code == kVirtNoError) return 0;
  error_ = code;
  return -1;
}

void Device::remark(const std::string& text) {
  if (log_.is_open()) log_ << arm.time() << " order: " << text << '\n';
}

void Device::show(const Pose& pose, float* out) const {
  std::copy(pose.begin(), pose.end(), out);
  double value = 0;
  if (arm.is_on(EventKind::nan_position)) out[0] = std::numeric_limits<float>::quiet_NaN();
  if (arm.is_on(EventKind::bad_quaternion)) out[6] += 0.5F;
  if (arm.is_on(EventKind::jump, &value)) out[0] += static_cast<float>(value);
}

}  // namespace palp::fake
