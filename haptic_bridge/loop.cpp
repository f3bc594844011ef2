#include "haptic_bridge/loop.h"

namespace palp {

const char* to_string(LoopState state) {
  constexpr std::array<const char*, 8> kNames{"waiting",  "ready", "engaged", "idle",
                                              "degraded", "stale", "locked",  "fault"};
  return kNames[static_cast<std::size_t>(state)];
}

const char* to_string(LoopFault fault) {
  switch (fault) {
    case LoopFault::none:
      return "";
    case LoopFault::device_read:
      return "the device gave no usable pose for too many ticks in a row: check its cable, power and calibration";
    case LoopFault::device_write:
      return "the device refused the wrench for too many ticks in a row: check its power and dead-man switch";
    case LoopFault::not_finite:
      return "the wrench became non-finite and was cut: the flight log shows the inputs";
  }
  return "";
}

HapticLoop::HapticLoop(const LoopConfig& config, HapticDevice& device)
    : config_(config),
      device_(device),
      gate_(config.device, config.own_session, config.gains),
      model_(config.blend_time > 0 ? std::exp(-1e-9 * static_cast<double>(config.period_ns) / config.blend_time) : 0),
      period_(1e-9 * static_cast<double>(config.period_ns)) {
  config_.limits.force = std::min(config.limits.force, device.info().force_limit);
  config_.limits.torque = std::min(config.limits.torque, device.info().torque_limit);
  reading_.state = record_.device;
  sample_.device = config.device;
  sample_.gains = config.gains;
}

void HapticLoop::tick(std::int64_t now_ns, std::int64_t lateness_ns, std::uint32_t missed,
                      const IncomingProxy* incoming) {
  record_.t_ns = now_ns;
  record_.lateness_ns = lateness_ns;
  record_.missed = missed;
  record_.verdict = -1;
  record_.cut = false;

  read_device(now_ns);
  if (incoming) take_sample(*incoming, now_ns);
  follow_link(now_ns);
  record_.model = have_sample_ ? model_.at(reading_.state) : zero_wrench();
  send(limited(record_.model));
  model_.decay();
  describe(now_ns);
}

void HapticLoop::read_device(std::int64_t now_ns) {
  DeviceReading next;
  record_.good_reading =
      device_.read(now_ns, next) && is_finite(next.state) && is_unit(next.state.q) && plausible(next.state, now_ns);
  if (!record_.good_reading) {
    ++report_.bad_readings;
    if (++bad_reads_in_a_row_ > config_.max_bad_ticks) fault_ = LoopFault::device_read;
    return;
  }
  bad_reads_in_a_row_ = 0;
  reading_ = next;
  reading_.state.q.normalize();
  have_reading_ = true;
  t_reading_ns_ = now_ns;
}

// A hand does not jump: neither the pose nor the twist may say so.
bool HapticLoop::plausible(const HandleState<double>& next, std::int64_t now_ns) const {
  if (next.v.norm() > config_.max_speed || next.w.norm() > config_.max_angular_speed) return false;
  if (!have_reading_) return true;
  const double elapsed = std::max(period_, 1e-9 * static_cast<double>(now_ns - t_reading_ns_));
  return (next.x - reading_.state.x).norm() <= config_.max_speed * elapsed &&
         rotation_between(reading_.state.q, next.q).norm() <= config_.max_angular_speed * elapsed;
}

void HapticLoop::take_sample(const IncomingProxy& in, std::int64_t now_ns) {
  const Verdict verdict = gate_.judge(in, now_ns);
  record_.verdict = static_cast<std::int32_t>(verdict);
  if (verdict != Verdict::accepted && verdict != Verdict::restarted) return;

  if (verdict == Verdict::restarted) {
    // a server that has just begun knows nothing of what the hand felt: begin anew, the slew limit softens the change
    qualified_ = false;
    engagement_ = 0;
    fresh_since_ns_ = now_ns;
    report_.server_session = in.sample.header.session;
  }
  if (engagement_ > 0) {
    model_.change(local_model(in.sample), reading_.state);
  } else {
    model_.reset(local_model(in.sample));
  }
  have_sample_ = true;
  t_receive_ns_ = in.t_receive_ns;
  t_device_ns_ = in.sample.t_device_ns;
  sample_flags_ = in.sample.flags;
  record_.sequence = in.sample.header.sequence;
  record_.sim_time = in.sample.sim_time;
  record_.proxy = to_vector(in.sample.proxy_pose.position);
}

// How old the data is, whether it may be felt, and how much of it.
void HapticLoop::follow_link(std::int64_t now_ns) {
  bool stale = false;
  if (have_sample_) {
    record_.delay_ns = now_ns - t_device_ns_;
    record_.age_ns =
        std::max<std::int64_t>({0, now_ns - t_receive_ns_, record_.delay_ns - config_.round_trip_allowance_ns});
    record_.stale_scale = stale_scale(record_.age_ns, config_.stale);
    stale = record_.age_ns >= config_.stale.zero_at_ns;
    if (stale) {
      qualified_ = false;
      engagement_ = 0;
      gate_.forget_previous_session();
      if (!was_stale_) ++report_.stale_events;
    }
    if (record_.age_ns > config_.stale.fade_start_ns) {
      fresh_since_ns_ = now_ns;
    } else if (now_ns - fresh_since_ns_ >= config_.fresh_ns) {
      qualified_ = true;
    }
  }
  was_stale_ = stale;

  // faults of the device and a lifted hand end the force in this very tick
  record_.cut = stale || !record_.good_reading || !reading_.engaged() || fault_ != LoopFault::none;
  if (record_.cut) engagement_ = 0;
  const std::uint32_t wanted = kEngaged | kHealthy;
  const bool willing = qualified_ && !record_.cut && (sample_flags_ & (wanted | kPaused)) == wanted;
  engagement_ = ramped(engagement_, willing ? 1 : 0, period_ / config_.ramp_up, period_ / config_.ramp_down);
  record_.engagement = engagement_;
  record_.state = find_state(willing);
}

LoopState HapticLoop::find_state(bool willing) const {
  if (fault_ != LoopFault::none) return LoopState::fault;
  if (!have_sample_) return LoopState::waiting;
  if (was_stale_) return LoopState::stale;
  if (!qualified_) return LoopState::ready;
  if (!willing) return LoopState::idle;
  return record_.age_ns > config_.stale.fade_start_ns ? LoopState::degraded : LoopState::engaged;
}

// The chain of limits. Each stage keeps what the stages before it promised: a mix of two vectors within the limit is
// within the limit, and so is a step from one such vector towards another.
Wrench<double> HapticLoop::limited(const Wrench<double>& wanted) {
  if (!is_finite(wanted)) {
    fault_ = LoopFault::not_finite;
    record_.cut = true;
  }
  if (record_.cut) return zero_wrench();

  const Wrench<double> damping{-config_.fade_damping * reading_.state.v,
                               -config_.fade_angular_damping * reading_.state.w};
  const Wrench<double> kept = saturated(wanted, config_.limits), fading = saturated(damping, config_.limits);
  const double g = record_.stale_scale, e = engagement_;
  const Wrench<double> mixed{e * (g * kept.force + (1 - g) * fading.force),
                             e * (g * kept.torque + (1 - g) * fading.torque)};
  return slewed(last_sent_, mixed, config_.limits, period_);
}

void HapticLoop::send(const Wrench<double>& wrench) {
  const bool finite = is_finite(wrench);
  if (!finite) fault_ = LoopFault::not_finite;
  record_.sent = finite ? wrench : zero_wrench();
  if (device_.write(record_.sent)) {
    bad_writes_in_a_row_ = 0;
  } else {
    ++report_.bad_writes;
    if (++bad_writes_in_a_row_ > config_.max_bad_ticks) fault_ = LoopFault::device_write;
  }
  if (record_.cut && last_sent_.force.squaredNorm() + last_sent_.torque.squaredNorm() > 0) ++report_.cuts;
  last_sent_ = record_.sent;
}

// What the server, the log and the people get to know of this tick.
void HapticLoop::describe(std::int64_t now_ns) {
  const bool healthy = fault_ == LoopFault::none && record_.good_reading;
  sample_.flags = (healthy ? kHealthy : 0u) | (healthy && reading_.engaged() ? kEngaged : 0u) |
                  ((reading_.buttons & 1u) ? kButton0 : 0u) | ((reading_.buttons & 2u) ? kButton1 : 0u);
  sample_.t_device_ns = record_.good_reading ? now_ns : t_reading_ns_;
  sample_.pose = to_pose(reading_.state);
  sample_.twist = record_.good_reading ? to_twist(reading_.state) : TwistD{};

  if (fault_ != LoopFault::none) record_.state = LoopState::fault;
  record_.tick = ++report_.ticks;
  record_.device = reading_.state;
  record_.engaged_device = reading_.engaged();
  record_.blend_linear = model_.model().blend_linear;
  record_.blend_angular = model_.model().blend_angular;

  if (report_.ticks == 1) report_.t_first_ns = now_ns;
  report_.t_last_ns = now_ns;
  report_.missed += record_.missed;
  report_.state = record_.state;
  report_.fault = fault_;
  report_.passed_over = gate_.passed_over();
  report_.verdicts = gate_.counts();
  report_.age_ns = record_.age_ns;
  report_.force = record_.sent.force.norm();
  report_.torque = record_.sent.torque.norm();
  report_.peak_force = std::max(report_.peak_force, report_.force);
  report_.peak_torque = std::max(report_.peak_torque, report_.torque);
}

}  // namespace palp
