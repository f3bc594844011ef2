#include "haptic_bridge/loop/sample_gate.h"

#include "haptic_bridge/loop/local_model.h"

namespace palp {

namespace {

// Far beyond anything that a simulation at hand's scale can mean, and small enough that no product overflows.
constexpr double kAbsurd = 1e6;

template <std::size_t N>
bool sane(const std::array<double, N>& a) {
  for (double x : a) {
    if (!(std::abs(x) < kAbsurd)) return false;
  }
  return true;
}

template <std::size_t N>
bool all_finite(const std::array<double, N>& a) {
  for (double x : a) {
    if (!std::isfinite(x)) return false;
  }
  return true;
}

bool all_finite(const ProxySample& s) {
  return all_finite(s.device_pose.position) && all_finite(s.device_pose.orientation) &&
         all_finite(s.device_twist.linear) && all_finite(s.device_twist.angular) && all_finite(s.proxy_pose.position) &&
         all_finite(s.proxy_pose.orientation) && all_finite(s.proxy_twist.linear) &&
         all_finite(s.proxy_twist.angular) && all_finite(s.wrench.force) && all_finite(s.wrench.torque) &&
         all_finite(s.blend) && all_finite(s.energy) && std::isfinite(s.gains.stiffness) &&
         std::isfinite(s.gains.damping) && std::isfinite(s.gains.angular_stiffness) &&
         std::isfinite(s.gains.angular_damping);
}

bool sane(const ProxySample& s) {
  return sane(s.device_pose.position) && sane(s.device_twist.linear) && sane(s.device_twist.angular) &&
         sane(s.proxy_pose.position) && sane(s.wrench.force) && sane(s.wrench.torque) && sane(s.energy);
}

bool within(double value, double most) { return value >= 0 && value <= most * (1 + 1e-9); }

}  // namespace

const char* to_string(Verdict verdict) {
  constexpr std::array<const char*, kVerdicts> kNames{"accepted",  "restarted",    "not_finite",   "bad_range",
                                                      "bad_gains", "out_of_order", "other_bridge", "repeated"};
  return kNames[static_cast<std::size_t>(verdict)];
}

Verdict SampleGate::check_content(const ProxySample& s, std::int64_t now_ns) const {
  if (!all_finite(s)) return Verdict::not_finite;
  if (s.device != device_ || s.header.session == 0 || s.header.sequence == 0) return Verdict::bad_range;
  // a server that has not heard this bridge yet has nothing to say to it
  if (s.device_session != own_session_) return Verdict::other_bridge;
  if (!sane(s) || !is_unit(to_quaternion(s.device_pose.orientation)) ||
      !is_unit(to_quaternion(s.proxy_pose.orientation)) || s.t_device_ns <= 0 || s.t_device_ns > now_ns ||
      s.blend[0] < 0 || s.blend[0] > 1 || s.blend[1] < 0 || s.blend[1] > 1)
    return Verdict::bad_range;
  if (!within(s.gains.stiffness, proposed_.stiffness) || !within(s.gains.damping, proposed_.damping) ||
      !within(s.gains.angular_stiffness, proposed_.angular_stiffness) ||
      !within(s.gains.angular_damping, proposed_.angular_damping))
    return Verdict::bad_gains;
  return Verdict::accepted;
}

Verdict SampleGate::judge(const IncomingProxy& in, std::int64_t now_ns) {
  const Header& header = in.sample.header;
  Verdict verdict = check_content(in.sample, now_ns);
  if (verdict == Verdict::accepted) {
    if (header.session != session_) {
      verdict = header.session == previous_session_ ? Verdict::out_of_order : Verdict::restarted;
    } else if (header.sequence <= sequence_) {
      verdict = Verdict::out_of_order;
    }
  }
  const bool answers_anew = in.sample.sim_time != sim_time_ || in.sample.t_device_ns != t_device_ns_;
  if (verdict == Verdict::restarted) {
    previous_session_ = session_;
    session_ = header.session;
  } else if (verdict == Verdict::accepted) {
    passed_over_ += header.sequence - sequence_ - 1;
  }
  if (verdict == Verdict::restarted || verdict == Verdict::accepted) {
    sequence_ = header.sequence;
    sim_time_ = in.sample.sim_time;
    t_device_ns_ = in.sample.t_device_ns;
  }
  if (verdict == Verdict::accepted && (in.sample.flags & kRepeated) && !answers_anew) verdict = Verdict::repeated;
  ++counts_[static_cast<std::size_t>(verdict)];
  return verdict;
}

}  // namespace palp
