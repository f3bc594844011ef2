// The limits and safety rules of the loop, restated from their description and judged tick by tick from outside: what
// the arm said, what came from the bus, what was sent. Shares no code with the loop.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/haptic_bridge/loop/fake_server.h"

namespace palp::test {

class Invariants {
 public:
  explicit Invariants(const LoopConfig& config) : c_(config) {}

  // Returns what is wrong with this tick, or null. loop: after the tick.
  const char* judge(const HapticLoop& loop, const Wrench<double>& sent) {
    const TickInput& in = loop.input();
    const double dt = seconds(std::max(c_.period_ns, in.now_ns - t_last_ns_));
    if (t_last_ns_ == 0) t_good_sample_ns_ = in.now_ns;
    t_last_ns_ = in.now_ns;
    // a hand that lets go in the tick of a late tick or of an unsound sample has let go since
    follow_time(in);
    follow_samples(in, loop.record().verdict);
    follow_reading(in);
    follow_switches(in);
    if (have_sample_ && in.now_ns - t_good_sample_ns_ >= 100 * kMillisecond) trip();
    const char* wrong = judge_force(in, loop, sent, dt);
    before_ = sent;
    return wrong;
  }

 private:
  static double seconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }
  static bool plain(double x) { return x - x == 0; }
  static bool plain(const Eigen::Vector3d& v) { return plain(v.x()) && plain(v.y()) && plain(v.z()); }

  // Takes the reading as good when it is a pose that a hand can have reached since the last good one.
  void follow_reading(const TickInput& in) {
    const RigidState& s = in.reading.state;
    const double length = s.orientation.coeffs().stableNorm();
    good_ = in.was_read && plain(s.position) && plain(s.linear) && plain(s.angular) && plain(length) &&
            std::abs(length - 1) <= 1e-3 && s.position.stableNorm() <= kFarthest && s.linear.norm() <= c_.max_speed &&
            s.angular.norm() <= c_.max_angular_speed;
    if (good_ && have_reading_) {
      // one step of the arm's own clock more than ours
      const double elapsed = seconds(c_.period_ns + std::max(c_.period_ns, in.now_ns - t_reading_ns_));
      const Eigen::Quaterniond q = s.orientation.normalized();
      const double angle = 2 * std::acos(std::min(1.0, std::abs(q.dot(q_))));
      good_ = (s.position - x_).norm() <= c_.max_speed * elapsed && angle <= c_.max_angular_speed * elapsed + 1e-6;
    }
    bad_in_a_row_ = good_ ? 0 : bad_in_a_row_ + 1;
    gone_ = gone_ || bad_in_a_row_ > c_.max_bad_ticks;
    if (!good_) return;
    have_reading_ = true;
    t_reading_ns_ = in.now_ns;
    x_ = s.position;
    v_ = s.linear;
    w_ = s.angular;
    q_ = s.orientation.normalized();
  }

  // Finds whether the hand has let go, with all well, since whatever ended the force.
  void follow_switches(const TickInput& in) {
    if (!good_) return;
    const bool on = in.reading.powered && in.reading.chain_closed;
    if (was_on_ && !on) may_hold_ = holds_ = false;
    was_on_ = on;
    if (!in.reading.dead_man) may_hold_ = true;
    holds_ = in.reading.dead_man && may_hold_;
    usable_ = on && in.reading.dead_man && !in.reading.shifted;
  }

  void follow_samples(const TickInput& in, std::int32_t verdict) {
    const auto is = [&](Verdict v) { return in.came && verdict == static_cast<std::int32_t>(v); };
    if (is(Verdict::not_finite) || is(Verdict::bad_range) || is(Verdict::bad_gains)) {
      if (++unsound_ > c_.safety.bad_samples) trip();
    } else if (is(Verdict::accepted) || is(Verdict::restarted)) {
      unsound_ = 0;
      t_good_sample_ns_ = std::min(in.incoming.t_receive_ns, in.now_ns);
      have_sample_ = true;
    }
  }

  void follow_time(const TickInput& in) {
    late_ = 2 * in.lateness_ns > c_.period_ns ? late_ + 1 : 0;
    const bool overrun = c_.safety.overrun_ns > 0 && in.lateness_ns > c_.safety.overrun_ns;
    if (!overrun && (c_.safety.late_ticks == 0 || late_ < c_.safety.late_ticks)) return;
    late_ = 0;
    trip();
  }
  void trip() { may_hold_ = holds_ = false; }

  const char* judge_force(const TickInput& in, const HapticLoop& loop, const Wrench<double>& sent, double dt) {
    const WrenchLimits& most = c_.limits;
    const double period = seconds(c_.period_ns);
    if (!plain(sent.force) || !plain(sent.torque)) return "a wrench that is no number";
    const bool zero = sent.force.isZero(0) && sent.torque.isZero(0);
    if (!zero && (!good_ || gone_)) return "force on a reading that cannot be";
    if (!zero && !(usable_ && holds_)) return "force in a hand that does not hold on";
    if (!zero && (!have_sample_ || in.now_ns - t_good_sample_ns_ >= 100 * kMillisecond))
      return "force without a server";
    if (sent.force.norm() > most.force + kSlack || sent.torque.norm() > most.torque + kSlack) return "length";
    for (int i = 0; i < 3; ++i)
      if (std::abs(sent.force[i]) > most.axis_force[i] + kSlack ||
          std::abs(sent.torque[i]) > most.axis_torque[i] + kSlack)
        return "axis";
    const double power = zero ? 0 : sent.force.dot(v_) + sent.torque.dot(w_);
    if (power > most.power + kSlack) return "power";
    // a cut is exempt, and so is what the power limit takes away, which leaves exactly that much power
    const bool at_power = power > most.power - 1e-6;
    if (!zero && !at_power &&
        ((sent.force - before_.force).norm() > most.force_slew * period + kSlack ||
         (sent.torque - before_.torque).norm() > most.torque_slew * period + kSlack))
      return "slope";
    // from a cut on all force is on a ramp
    since_cut_ = loop.record().cut ? 0 : since_cut_ + 1;
    if (loop.record().cut && !zero) return "cut but not zero";
    const double share = std::min(1.0, since_cut_ * period / std::min(c_.ramp_up, c_.ramp_after_clutch));
    if (sent.force.norm() > share * most.force + kSlack || sent.torque.norm() > share * most.torque + kSlack)
      return "ramp";
    if (!judge_motors(sent, dt)) return "motors too warm";
    strained_ticks_ = good_ && in.reading.strained ? strained_ticks_ + 1 : 0;
    if (strained_ticks_ > 1 + 2 * most.force / (most.force_slew * period) &&
        sent.force.norm() > most.force / 2 + kSlack)
      return "a strained arm with more than half of the force";
    if (!judge_damping(in, sent, period)) return "more than damping";
    return judge_sample(loop);
  }

  // Checks that the mean square over ten seconds stays within what the motors hold for ever. What a wrench does for as
  // long as the loop is late nobody could have foreseen.
  bool judge_motors(const Wrench<double>& sent, double dt) {
    constexpr double kTime = 10;       // [s]
    constexpr double kAllowed = 1.02;  // of the square, for rounding
    const auto mean = [&](double& square, double now) {
      square += (now > square ? std::min(dt, 2 * seconds(c_.period_ns)) : dt) / kTime * (now - square);
    };
    mean(warm_, sent.force.squaredNorm());
    mean(warm_torque_, sent.torque.squaredNorm());
    const WrenchLimits& l = c_.limits;
    return warm_ <= kAllowed * l.continuous_force * l.continuous_force + kSlack &&
           warm_torque_ <= kAllowed * l.continuous_torque * l.continuous_torque + kSlack;
  }

  // Checks that nothing is left but damping with data older than 60 ms, or while the arm is too fast, once the slope
  // has had its time.
  bool judge_damping(const TickInput& in, const Wrench<double>& sent, double period) {
    const bool old = in.now_ns - t_good_sample_ns_ >= 60 * kMillisecond;
    const bool fast = v_.norm() > c_.safety.tool_speed || w_.norm() > c_.safety.tool_turn;
    damped_ticks_ = old || fast ? damped_ticks_ + 1 : 0;
    fastest_ = damped_ticks_ == 0 ? 0 : std::max(fastest_, v_.norm());
    const double needed = 2 * c_.limits.force / (c_.limits.force_slew * period);
    return damped_ticks_ <= needed + 1 || sent.force.norm() <= c_.fade_damping * fastest_ + kSlack;
  }

  // Returns what is wrong with the sample that the server is told, or null.
  const char* judge_sample(const HapticLoop& loop) const {
    const DeviceSample& s = loop.sample();
    double sum = 0;
    for (const double x : s.pose.position) sum += x;
    for (const double x : s.pose.orientation) sum += x;
    for (const double x : s.twist.linear) sum += x;
    for (const double x : s.twist.angular) sum += x;
    if (!plain(sum)) return "a sample that is no number";
    const double scale = c_.workspace.motion_scale * c_.workspace.force_scale;
    if (!(s.gains.stiffness >= 0) || s.gains.stiffness * scale > c_.gains.stiffness * (1 + 1e-9)) return "gains";
    if ((s.flags & kEngaged) != 0 && !(usable_ && holds_)) return "the server is told of a hand that is not there";
    return nullptr;
  }

  static constexpr double kSlack = 1e-9;    // rounding
  static constexpr double kFarthest = 1e3;  // that a handle can be [m]
  LoopConfig c_;
  std::int64_t t_last_ns_ = 0, t_reading_ns_ = 0, t_good_sample_ns_ = 0;
  bool have_reading_ = false, have_sample_ = false, good_ = false, gone_ = false;
  bool was_on_ = false, may_hold_ = false, holds_ = false, usable_ = false;
  int bad_in_a_row_ = 0, unsound_ = 0, late_ = 0;
  double since_cut_ = 0, damped_ticks_ = 0, strained_ticks_ = 0, fastest_ = 0, warm_ = 0, warm_torque_ = 0;
  Eigen::Vector3d x_ = Eigen::Vector3d::Zero(), v_ = Eigen::Vector3d::Zero(), w_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  Wrench<double> before_ = zero_wrench();
};

}  // namespace palp::test
