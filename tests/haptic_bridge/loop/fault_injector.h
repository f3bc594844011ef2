// A world that does everything wrong, by the draw of its seed: the server, the bus, the arm and the scheduler.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <random>

#include "haptic_bridge/device/simulated.h"
#include "tests/haptic_bridge/loop/fake_server.h"

namespace palp::test {

class FaultInjector {
 public:
  explicit FaultInjector(std::uint64_t seed) : random_(seed) {
    for (double* p : {&lose_, &lie_, &glitch_, &lift_, &late_, &restart_, &reorder_, &duplicate_, &refuse_, &jump_})
      *p = chance(0.5) ? 0 : 0.2 * unit() * unit();
    for (double* p : {&shift_, &power_, &chain_, &strain_, &lull_}) *p = chance(0.7) ? 0 : 0.02 * unit();
    scale_ = std::pow(10, 4 * unit() - 1);  // 0.1 .. 1000 N
    noise_ = chance(0.5) ? 1 : 0.1;
    for (double& p : push_) p = noise_ < 1 ? normal_(random_) : 0;  // for long enough to warm the motors
    delay_ = chance(0.7) ? 0 : static_cast<std::size_t>(40 * unit());
    blend_ = unit();
    speed_ = chance(0.5) ? 0 : 6 * unit() * unit();
  }

  LoopConfig config() {
    LoopConfig c;
    c.own_session = kBridgeSession;
    c.limits = {0.5 + 30 * unit(), 0.1 + 2 * unit(), 50 + 500 * unit(), 5 + 50 * unit()};
    c.limits.power = 0.1 + 10 * unit();
    if (chance(0.5))
      for (int i = 0; i < 3; ++i) {
        c.limits.axis_force[i] = c.limits.force * unit();
        c.limits.axis_torque[i] = c.limits.torque * unit();
      }
    if (chance(0.5)) {
      c.limits.continuous_force = c.limits.force * (0.05 + 0.95 * unit() * unit());
      c.limits.continuous_torque = c.limits.torque * (0.05 + 0.95 * unit() * unit());
    }
    if (chance(0.3)) c.workspace = {std::pow(10, 2 * unit() - 1), std::pow(10, 2 * unit() - 1), chance(0.5)};
    if (chance(0.3)) c.governor.budget = c.governor.angular_budget = unit();
    if (chance(0.5)) {  // quick to engage, so that short schedules feel something
      c.fresh_ns = 0;
      c.ramp_up = 0.01;
      c.ramp_after_clutch = 0.02;
    }
    if (chance(0.2)) c.safety.overrun_ns = 0;
    if (chance(0.3)) c.safety.late_ticks = chance(0.5) ? 0 : 3;
    if (chance(0.3)) c.max_bad_ticks = 3;
    return c;
  }

  std::int64_t wait_ns() { return chance(late_) ? std::llround(60e6 * unit() * unit()) + kMillisecond : kMillisecond; }

  // Gives the sample that comes in this tick. False: none comes.
  bool next(const DeviceSample& device, std::int64_t now, IncomingProxy& in) {
    heard_.push_back(device);
    if (heard_.size() > delay_ + 1) heard_.pop_front();
    if (silence_left_ <= 0 && chance(0.001)) silence_left_ = static_cast<int>(200 * unit());
    if (--silence_left_ > 0 || chance(lose_)) return false;
    if (chance(duplicate_) && last_.sample.header.sequence > 0) {
      in = last_;
      return true;
    }
    if (chance(restart_)) session_ = 1 + random_() % 3, sequence_ = 0;
    if (chance(0.3 * restart_)) time_ = 0;  // the simulation was reset
    in.sample = answer(heard_.front(), session_, ++sequence_);
    in.t_receive_ns = now - (chance(0.1) ? static_cast<std::int64_t>(30e6 * unit()) : 0);
    if (chance(reorder_)) in.sample.header.sequence = 1 + random_() % (sequence_ + 2);
    in.sample.sim_time = time_ += 1e-3;
    for (std::size_t i = 0; i < 3; ++i) {
      in.sample.wrench.force[i] = scale_ * (push_[i] + noise_ * normal_(random_));
      in.sample.wrench.torque[i] = 0.1 * scale_ * (push_[i] + noise_ * normal_(random_));
    }
    in.sample.blend = {blend_, unit()};
    for (double& e : in.sample.energy) e = 1e-3 * normal_(random_);
    in.sample.flags = chance(0.02) ? static_cast<std::uint32_t>(random_() % 8) : kEngaged | kHealthy;
    if (chance(lie_)) lie(in.sample);
    last_ = in;
    return true;
  }

  // Sets what the switches of the arm say, and what its readings become. True: the arm gave a reading.
  bool trouble(DeviceReading& r, bool regrip) {
    follow(lifted_, lift_, 0.3);
    follow(shifted_, shift_, 0.1);
    follow(off_, power_, 0.2);
    follow(open_, chain_, 0.2);
    follow(strained_, strain_, 0.02);
    r.dead_man = !lifted_ && !regrip;
    r.shifted = shifted_;
    r.powered = !off_;
    r.chain_closed = !open_;
    r.strained = strained_;
    if (chance(jump_)) r.state.position += 0.02 * Eigen::Vector3d(normal_(random_), normal_(random_), normal_(random_));
    if (chance(glitch_)) {
      double* const targets[] = {&r.state.position.x(), &r.state.orientation.w(), &r.state.linear.y(),
                                 &r.state.angular.z()};
      *targets[random_() % 4] = bad_number();
    }
    return lull() != 1;
  }
  bool takes_wrench() { return !chance(refuse_); }
  // Returns the speed up to which the hand throws the arm about [m/s]; 0: it is held.
  double speed() const { return speed_; }
  double swing() { return normal_(random_); }

 private:
  double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  bool chance(double p) { return p > 0 && unit() < p; }
  void follow(bool& on, double begins, double ends) { on = on ? !chance(ends) : chance(begins); }
  // Readings that fail come in runs, so that some schedules end with the arm given up. 1: fails.
  int lull() {
    if (lull_left_ > 0) return --lull_left_ > 0 ? 1 : 0;
    if (chance(lull_)) lull_left_ = static_cast<int>(30 * unit());
    return lull_left_ > 0 ? 1 : 0;
  }
  double bad_number() {
    const double kBad[] = {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL, 1e308, -1e308, 1e-310, 1e7};
    return kBad[random_() % 7];
  }
  void lie(ProxySample& s) {
    double* const targets[] = {&s.wrench.force[0],
                               &s.wrench.torque[1],
                               &s.device_pose.position[2],
                               &s.device_pose.orientation[3],
                               &s.proxy_pose.orientation[0],
                               &s.device_twist.linear[0],
                               &s.device_twist.angular[1],
                               &s.gains.stiffness,
                               &s.gains.angular_damping,
                               &s.blend[0],
                               &s.energy[1],
                               &s.proxy_pose.position[1]};
    if (chance(0.2)) {
      s.t_device_ns = static_cast<std::int64_t>(random_());
    } else if (chance(0.2)) {
      s.device = static_cast<std::uint32_t>(random_() % 3);
    } else if (chance(0.1)) {
      s.device_session = random_() % 3;
    } else {
      *targets[random_() % 12] = bad_number();
    }
  }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  double lose_, lie_, glitch_, lift_, late_, restart_, reorder_, duplicate_, refuse_, jump_;
  double shift_, power_, chain_, strain_, lull_, scale_, noise_, blend_, speed_;
  std::array<double, 3> push_{};
  std::size_t delay_;  // of the link [ticks]
  bool lifted_ = false, shifted_ = false, off_ = false, open_ = false, strained_ = false;
  int silence_left_ = 0, lull_left_ = 0;
  std::uint64_t session_ = 1, sequence_ = 0;
  double time_ = 0;
  IncomingProxy last_;
  std::deque<DeviceSample> heard_;
};

// An arm whose readings go wrong now and then, whose switches come and go, and that a hand may throw about.
class FaultyArm final : public HapticDevice {
 public:
  explicit FaultyArm(FaultInjector& injector)
      : injector_(injector), arm_(ArmModel{}, HandScript{}, home(), home()), thrown_(home()) {}
  const DeviceInfo& info() const noexcept override { return arm_.info(); }
  bool read(std::int64_t now, DeviceReading& out) noexcept override {
    bool good = arm_.read(now, out);
    if (injector_.speed() > 0) {
      throw_about(now);
      out.state = thrown_;
    }
    good = injector_.trouble(out, !held_) && good;
    held_ = true;
    return good;
  }
  void show(LoopState state) noexcept override {
    if (state == LoopState::locked) held_ = false;
  }
  bool write(const Wrench<double>& w) noexcept override {
    written = w;
    arm_.write(w);
    return injector_.takes_wrench();
  }
  Wrench<double> written = zero_wrench();

 private:
  static RigidState home() {
    return {Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  }
  // A speed that wanders, up to the largest.
  void throw_about(std::int64_t now) {
    const double dt = t_last_ > 0 ? 1e-9 * static_cast<double>(now - t_last_) : 1e-3;
    t_last_ = now;
    for (int i = 0; i < 3; ++i) {
      thrown_.linear[i] += 0.2 * injector_.speed() * injector_.swing();
      thrown_.angular[i] += injector_.speed() * injector_.swing();
    }
    thrown_.linear = saturated(thrown_.linear, injector_.speed());
    thrown_.angular = saturated(thrown_.angular, 5 * injector_.speed());
    thrown_.position += dt * thrown_.linear;
    const double angle = dt * thrown_.angular.norm();
    if (angle > 0)
      thrown_.orientation =
          (Eigen::Quaterniond(Eigen::AngleAxisd(angle, thrown_.angular.normalized())) * thrown_.orientation)
              .normalized();
  }

  FaultInjector& injector_;
  SimulatedDevice arm_;
  RigidState thrown_;
  std::int64_t t_last_ = 0;
  bool held_ = false;
};

}  // namespace palp::test
