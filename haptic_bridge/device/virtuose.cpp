#include "haptic_bridge/device/virtuose.h"

#include <cmath>

#include <fmt/format.h>

#include "idl/coupling.h"

namespace palp {

namespace {

constexpr int kButtons = 3;
constexpr int kTurns = 4 + kButtons;  // what is read in turn
constexpr std::int64_t kFrozenNs = 50'000'000;
constexpr double kMoving = 0.02;  // [m/s]: a pose that stands still at this speed is an old one
constexpr double kTurning = 0.2;  // [rad/s]

// Errors of the link, which may pass. Anything else means that the arm has stopped or that we misuse it.
bool passes_by(int code) { return code == kVirtCommunication || code == kVirtTimeOut || code == kVirtNotAvailable; }

template <std::size_t N>
bool finite(const std::array<float, N>& values) {
  for (const float v : values)
    if (!std::isfinite(v)) return false;
  return true;
}

bool is_pose(const ArmPose& p) {
  if (!finite(p)) return false;
  const float length = std::sqrt(p[3] * p[3] + p[4] * p[4] + p[5] * p[5] + p[6] * p[6]);
  return std::abs(length - 1) <= kUnitTolerance;
}

}  // namespace

VirtuoseDevice::VirtuoseDevice(const VirtuoseSetup& setup, const RigidState& start)
    : setup_(setup),
      session_(setup),
      frame_(setup.axes, start),
      info_{session_.name(), setup.limits.force, setup.limits.torque, true},
      state_in_world_(start) {
  find_buttons();
}

// Which buttons there are depends on the handle.
void VirtuoseDevice::find_buttons() noexcept {
  for (int i = 0; i < kButtons; ++i) {
    int pressed = 0;
    if (session_.api().get_button.function(session_.context(), i, &pressed) == 0) has_button_ |= 1u << i;
  }
}

bool VirtuoseDevice::passed(const char* call, int result) noexcept {
  if (result == 0) return true;
  const int code = session_.api().error_code(session_.context());
  if (passes_by(code)) {
    trouble_ = {call, code};
  } else {
    break_down({call, code});
  }
  return false;
}

void VirtuoseDevice::break_down(const VirtuoseTrouble& trouble) noexcept {
  if (broken_) return;
  broken_ = true;
  trouble_ = trouble;
  session_.make_safe();
}

bool VirtuoseDevice::read(std::int64_t now_ns, DeviceReading& out) noexcept {
  good_reading_ = !broken_ && read_motion(out) && read_switches(now_ns, out) && read_in_turn();
  if (good_reading_ && stands_still(now_ns, out)) {
    trouble_ = {nullptr, 0, "its pose stands still although it says that it moves"};
    good_reading_ = false;
  }
  if (!good_reading_) return false;
  // while the hand moves the arm only, the tool rests
  if (out.shifted || !out.dead_man) {
    out.state.linear.setZero();
    out.state.angular.setZero();
  }
  state_in_world_ = out.state;
  out.chain_closed = chain_closed_;
  out.strained = bounds_ != 0 || (alarms_ & (kVirtOverheat | kVirtSaturated)) != 0;
  out.alarms = alarms_ | bounds_;
  out.buttons = buttons_;
  return true;
}

bool VirtuoseDevice::read_motion(DeviceReading& out) noexcept {
  const VirtuoseApi& api = session_.api();
  ArmPose pose{};
  if (!passes(api.get_avatar, pose.data()) || !passes(api.get_speed, speed_.data())) return false;
  if (!is_pose(pose) || !finite(speed_)) {
    trouble_ = {nullptr, 0, "it gives a pose or speed that is no number"};
    return false;
  }
  if (!placed_ || pose != pose_) t_moved_ns_ = 0;
  pose_ = pose;
  if (!placed_) frame_.place(pose);
  placed_ = true;
  out.state = frame_.to_world(pose, speed_);
  return true;
}

bool VirtuoseDevice::read_switches(std::int64_t now_ns, DeviceReading& out) noexcept {
  const VirtuoseApi& api = session_.api();
  int dead_man = 0, power = 0, shifted = 0;
  if (!passes(api.get_dead_man, &dead_man) || !passes(api.get_power_on, &power) || !passes(api.is_shifted, &shifted))
    return false;
  if (power == 1 && !power_) t_power_ns_ = now_ns;
  // after an emergency stop the power comes back when the hand lets go or takes hold, not by itself
  const bool hand_acts = (dead_man == 1) != dead_man_;
  if (power == 1) was_stopped_ = false;
  if (hand_acts && was_stopped_ && chain_closed_ && !passes(api.set_power_on, 1)) return false;
  dead_man_ = dead_man == 1;
  power_ = power == 1;
  out.dead_man = dead_man_;
  out.powered = power_ && 1e-9 * static_cast<double>(now_ns - t_power_ns_) >= setup_.relay_time;
  out.shifted = shifted != 0;
  return true;
}

bool VirtuoseDevice::read_in_turn() noexcept {
  const VirtuoseApi& api = session_.api();
  const int turn = turn_;
  turn_ = (turn_ + 1) % kTurns;
  int flag = 0;
  unsigned bits = 0;
  switch (turn) {
    case 0:
      if (!passes(api.get_emergency_stop, &flag)) return false;
      chain_closed_ = flag == 1;
      if (!chain_closed_) was_stopped_ = true;
      return true;
    case 1:
      return passes(api.is_in_bounds, &bounds_);
    case 2:
      if (!passes(api.get_alarm, &alarms_)) return false;
      if (alarms_ & kVirtErrorPosition)
        break_down({nullptr, 0, "it reports an error of its position, calibrate it anew; alarm", alarms_});
      return !broken_;
    case 3:
      if (!passes(api.get_failure, &bits)) return false;
      if (bits != 0) break_down({nullptr, 0, "it reports a failure of its motors; failure", bits});
      return !broken_;
    default:
      break;
  }
  const std::uint32_t bit = 1u << (turn - 4);
  if (!(has_button_ & bit)) return true;
  if (!passes(api.get_button, turn - 4, &flag)) return false;
  buttons_ = flag ? buttons_ | bit : buttons_ & ~bit;
  return true;
}

// A controller that has stopped shows its last state for ever.
bool VirtuoseDevice::stands_still(std::int64_t now_ns, const DeviceReading& reading) noexcept {
  const bool moves = reading.state.linear.norm() > kMoving || reading.state.angular.norm() > kTurning;
  // while the hand moves the arm only, the tool rests and the speed is the arm's
  if (t_moved_ns_ == 0 || !moves || !power_ || !reading.dead_man || reading.shifted) t_moved_ns_ = now_ns;
  return now_ns - t_moved_ns_ > kFrozenNs;
}

bool VirtuoseDevice::write(const Wrench<double>& wrench) noexcept {
  if (!is_finite(wrench)) return false;
  if (broken_) return wrench.force.isZero(0) && wrench.torque.isZero(0);  // which it has been given
  return setup_.mode == VirtuoseMode::impedance ? write_force(wrench) : write_target(wrench);
}

bool VirtuoseDevice::write_force(const Wrench<double>& wrench) noexcept {
  const VirtuoseApi& api = session_.api();
  ArmVector force = frame_.to_arm(wrench.force, wrench.torque);
  if (passes(api.set_force, force.data())) return true;
  force.fill(0);
  if (!broken_) api.set_force.function(session_.context(), force.data());
  return false;
}

// The controller renders K (target - handle) + B (target speed - speed). A resting target so far from the handle that
// this is the wanted wrench: so all limits of the loop hold here, too, and while the bridge holds one wrench against a
// wall, what the controller renders in between is that wall.
bool VirtuoseDevice::write_target(const Wrench<double>& wrench) noexcept {
  const VirtuoseApi& api = session_.api();
  // the coupling is off while nothing may be felt: it would pull a moving hand towards where it was a tick ago
  const bool wanted = good_reading_ && (state_ == LoopState::engaged || state_ == LoopState::degraded);
  if (wanted != feedback_ && !passes(api.enable_feedback, wanted ? 1 : 0)) return false;
  feedback_ = wanted;

  const CouplingGains& k = setup_.gains;
  const RigidState& h = state_in_world_;
  const Eigen::Vector3d offset = (wrench.force + k.damping * h.linear) / k.stiffness;
  const Eigen::Vector3d turn = saturated(
      Eigen::Vector3d((wrench.torque + k.angular_damping * h.angular) / k.angular_stiffness), kMaxCouplingAngle);
  ArmPose target = frame_.to_arm(h.position + offset, rotation_by(turn) * h.orientation);
  ArmVector still{};
  return passes(api.set_position, target.data()) && passes(api.set_speed, still.data());
}

std::string VirtuoseDevice::trouble() const {
  if (trouble_.call)
    return fmt::format("{} at {}: {} failed: {} (error {})", info_.name, setup_.address, trouble_.call,
                       session_.api().message(trouble_.code), trouble_.code);
  if (trouble_.what && trouble_.bits)
    return fmt::format("{} at {}: {} {:#x}", info_.name, setup_.address, trouble_.what, trouble_.bits);
  if (trouble_.what) return fmt::format("{} at {}: {}", info_.name, setup_.address, trouble_.what);
  return {};
}

}  // namespace palp
