#include "haptic_bridge/loop/loop.h"

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
    case LoopFault::taken_for_dead:
      return "the loop stood still for so long that the supervisor powered the arm off: find what stops this machine "
             "(a debugger, a suspended process, too little priority), then start the bridge again";
    case LoopFault::unguarded:
      return "the supervisor has died or was stopped, and nobody would power the arm off if this bridge died, too: the "
             "force was ended; find what did it (a person, too little memory), then start the bridge again";
  }
  return "";
}

namespace {

// Returns the gains that the server is asked for, so that the hand feels the stiffness and damping that were
// configured.
CouplingGains scene_gains(const LoopConfig& c) {
  const double f = c.workspace.force_scale, sf = c.workspace.motion_scale * f;
  return {c.gains.stiffness / sf, c.gains.damping / sf, c.gains.angular_stiffness / f, c.gains.angular_damping / f};
}

bool unsound(Verdict v) { return v == Verdict::not_finite || v == Verdict::bad_range || v == Verdict::bad_gains; }

// An arm at its end, too warm or saturated gets half of the force.
double share_for(const DeviceReading& r) { return r.strained ? 0.5 : 1; }

constexpr double kFarthest = 1e3;  // from the origin: a handle further away than this is a broken reading [m]

// Returns how much of one vector another one renders, 0..1.
double share_of(const Eigen::Vector3d& sent, const Eigen::Vector3d& wanted, double where_none) {
  const double n = wanted.squaredNorm();
  return n < 1e-12 ? where_none : std::clamp(sent.dot(wanted) / n, 0.0, 1.0);
}

}  // namespace

HapticLoop::HapticLoop(const LoopConfig& config, HapticDevice& device)
    : config_(config),
      device_(device),
      gate_(config.device, config.own_session, scene_gains(config)),
      model_(config.blend_time > 0 ? std::exp(-1e-9 * static_cast<double>(config.period_ns) / config.blend_time) : 0),
      workspace_(config.workspace),
      governor_(config.governor, scene_gains(config), 1e-9 * static_cast<double>(config.period_ns)),
      passivity_(config.passivity),
      angular_passivity_(config.angular_passivity),
      thermal_limit_(config.limits.continuous_force, kWarmingTime, config.limits.force_slew),
      angular_thermal_limit_(config.limits.continuous_torque, kWarmingTime, config.limits.torque_slew),
      slope_(config.slew_recovery > 0
                 ? 1 - std::exp(-1e-9 * static_cast<double>(config.period_ns) / config.slew_recovery)
                 : 1),
      period_(1e-9 * static_cast<double>(config.period_ns)),
      referenced_(!config.workspace.relative) {
  config_.limits.force = std::min(config.limits.force, device.info().force_limit);
  config_.limits.torque = std::min(config.limits.torque, device.info().torque_limit);
  reading_.state = record_.device;
  report_.motion_scale = config.workspace.motion_scale;
  report_.force_scale = config.workspace.force_scale;
  sample_.device = config.device;
  sample_.gains = governor_.gains();
}

void HapticLoop::tick(std::int64_t now_ns, std::int64_t lateness_ns, std::uint32_t missed,
                      const IncomingProxy* incoming) {
  elapsed_ = report_.ticks > 0 ? std::max(period_, 1e-9 * static_cast<double>(now_ns - record_.t_ns)) : period_;
  input_.now_ns = record_.t_ns = now_ns;
  input_.lateness_ns = record_.lateness_ns = lateness_ns;
  input_.missed = record_.missed = missed;
  input_.told = fault_;
  input_.refused = refused_;
  input_.came = incoming != nullptr;
  if (incoming) input_.incoming = *incoming;
  record_.verdict = -1;
  record_.cut = record_.reduced = false;
  tripped_ = false;

  read_device(now_ns);
  follow_time(lateness_ns);
  if (refused_ > 0) {
    record_.verdict = static_cast<std::int32_t>(Verdict::not_finite);
    count_unsound(refused_);
    refused_ = 0;
  }
  if (incoming) judge_sample(*incoming, now_ns);
  follow_hand();
  follow_link(now_ns);
  observe_energy();
  send(apply_limits(render_wrench()));
  model_.decay();
  describe(now_ns);
  device_.show(record_.state);
}

void HapticLoop::read_device(std::int64_t now_ns) {
  input_.reading = {};
  input_.was_read = device_.read(now_ns, input_.reading);
  const DeviceReading& next = input_.reading;
  record_.good_reading =
      input_.was_read && is_finite(next.state) && is_unit(next.state.orientation) && plausible(next.state, now_ns);
  if (!record_.good_reading) {
    ++report_.bad_readings;
    if (++bad_reads_in_a_row_ > config_.max_bad_ticks) fault_ = LoopFault::device_read;
    return;
  }
  bad_reads_in_a_row_ = 0;
  reading_ = next;
  reading_.state.orientation.normalize();
  have_reading_ = true;
  t_reading_ns_ = now_ns;
}

// A hand does not jump: neither the pose nor the twist may say so. The arm's controller steps by a clock of its own, so
// that one period more of its motion may lie between two readings than between the ticks that took them.
bool HapticLoop::plausible(const RigidState& next, std::int64_t now_ns) const {
  if (next.position.stableNorm() > kFarthest || next.linear.norm() > config_.max_speed ||
      next.angular.norm() > config_.max_angular_speed)
    return false;
  if (!have_reading_) return true;
  const double elapsed = period_ + std::max(period_, 1e-9 * static_cast<double>(now_ns - t_reading_ns_));
  return (next.position - reading_.state.position).norm() <= config_.max_speed * elapsed &&
         rotation_between(reading_.state.orientation, next.orientation).norm() <= config_.max_angular_speed * elapsed;
}

// Ticks that come too late are felt as a softer, then as a kicking wall.
void HapticLoop::follow_time(std::int64_t lateness_ns) {
  const SafetyConfig& safety = config_.safety;
  late_in_a_row_ = 2 * lateness_ns > config_.period_ns ? late_in_a_row_ + 1 : 0;
  const bool overrun = safety.overrun_ns > 0 && lateness_ns > safety.overrun_ns;
  if (!overrun && (safety.late_ticks == 0 || late_in_a_row_ < safety.late_ticks)) return;
  late_in_a_row_ = 0;
  trip();
}

void HapticLoop::trip() {
  if (interlock_.held()) ++report_.trips;
  interlock_.trip();
  tripped_ = true;
}

void HapticLoop::count_unsound(std::uint64_t samples) {
  bad_samples_in_a_row_ += samples;
  if (bad_samples_in_a_row_ > static_cast<std::uint64_t>(config_.safety.bad_samples)) trip();
}

void HapticLoop::judge_sample(const IncomingProxy& in, std::int64_t now_ns) {
  const Verdict verdict = gate_.judge(in, now_ns);
  record_.verdict = static_cast<std::int32_t>(verdict);
  if (unsound(verdict)) count_unsound(1);
  if (verdict != Verdict::accepted && verdict != Verdict::restarted) return;
  bad_samples_in_a_row_ = 0;
  take_sample(in, verdict == Verdict::restarted || in.sample.sim_time < record_.sim_time, now_ns);
}

// begins: the server was started again, or its simulation was.
void HapticLoop::take_sample(const IncomingProxy& in, bool begins, std::int64_t now_ns) {
  if (begins) {
    // one that has just begun knows nothing of what the hand felt: begin anew, the slew limit softens the change
    qualified_ = false;
    engagement_ = 0;
    fresh_since_ns_ = now_ns;
    energy_ = in.sample.energy;
    report_.server_session = in.sample.header.session;
  }
  if (engagement_ > 0) {
    model_.change(local_model(in.sample), middle_);
  } else {
    model_.reset(local_model(in.sample));
  }
  have_sample_ = true;
  t_receive_ns_ = in.t_receive_ns;
  t_device_ns_ = in.sample.t_device_ns;
  governor_.note_delay(now_ns - t_device_ns_);
  sample_flags_ = in.sample.flags;
  for (std::size_t i = 0; i < 2; ++i) received_[i] += in.sample.energy[i] - energy_[i];
  energy_ = in.sample.energy;
  proxy_ = to_state(in.sample.proxy_pose, in.sample.proxy_twist);
  record_.sequence = in.sample.header.sequence;
  record_.sim_time = in.sample.sim_time;
  record_.proxy = proxy_.position;
}

// Finds whether the hand holds the tool, and where the arm's workspace lies in the scene.
void HapticLoop::follow_hand() {
  if (record_.good_reading) interlock_.update(reading_);
  if (reading_.shifted) shifted_ = true;
  if (reading_.shifted || (config_.workspace.relative && !interlock_.held())) referenced_ = false;
  if (!referenced_ && interlock_.held() && !reading_.shifted && have_sample_ && !was_stale_) {
    workspace_.reference(reading_.state, proxy_);
    referenced_ = true;
  }
  tool_ = workspace_.to_scene(reading_.state);
  middle_ = tool_;
  middle_.position += 0.5 * period_ * tool_.linear;
  middle_.orientation = rotation_by(0.5 * period_ * tool_.angular) * tool_.orientation;
}

// Finds how old the data is, whether it may be felt, and how much of it.
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
      gate_.forget_previous_session();
      if (!was_stale_) ++report_.stale_events;
      trip();
    }
    if (record_.age_ns > config_.stale.fade_start_ns) {
      fresh_since_ns_ = now_ns;
    } else if (now_ns - fresh_since_ns_ >= config_.fresh_ns) {
      qualified_ = true;
    }
  }
  was_stale_ = stale;
  const Wrench<double> carried = model_.at(middle_);
  governor_.update(record_.delay_ns, carried.force.norm(), carried.torque.norm());

  // faults of the device and a lifted hand end the force in this very tick
  record_.cut =
      tripped_ || !record_.good_reading || !reading_.engaged() || !interlock_.held() || fault_ != LoopFault::none;
  if (record_.cut) engagement_ = 0;
  const std::uint32_t wanted = kEngaged | kHealthy;
  const bool willing = qualified_ && referenced_ && !record_.cut && (sample_flags_ & (wanted | kPaused)) == wanted;
  const double rise = shifted_ ? config_.ramp_after_clutch : config_.ramp_up;
  engagement_ = ramped(engagement_, willing ? 1 : 0, period_ / rise, period_ / config_.ramp_down);
  if (engagement_ >= 1) shifted_ = false;
  record_.engagement = engagement_;
  record_.state = find_state(willing);
}

LoopState HapticLoop::find_state(bool willing) const {
  if (fault_ != LoopFault::none) return LoopState::fault;
  if (!have_sample_) return LoopState::waiting;
  if (was_stale_) return LoopState::stale;
  if (interlock_.locked(reading_)) return LoopState::locked;
  if (!qualified_ || (interlock_.held() && !referenced_)) return LoopState::ready;
  if (!willing) return LoopState::idle;
  return record_.age_ns > config_.stale.fade_start_ns ? LoopState::degraded : LoopState::engaged;
}

// Accounts for the energy that the hand got and gave since the last tick, and for the simulation's work. While less is
// sent than the coupling asks for, the simulation's work counts for the same share: the hand did not feel the rest.
void HapticLoop::observe_energy() {
  const Eigen::Vector3d moved = reading_.state.position - before_.position,
                        turned = rotation_between(before_.orientation, reading_.state.orientation);
  if (engagement_ > 0) {
    passivity_.observe(last_sent_.force, moved, reading_.state.linear,
                       rendered_[0] * workspace_.linear_work() * received_[0], stored_[0], elapsed_);
    angular_passivity_.observe(last_sent_.torque, turned, reading_.state.angular,
                               rendered_[1] * workspace_.angular_work() * received_[1], stored_[1], elapsed_);
  } else {
    passivity_.reset();
    angular_passivity_.reset();
  }
  received_ = {};
  before_ = reading_.state;
}

// Returns the wrench that the virtual coupling and the passivity controller ask for, before any limit.
Wrench<double> HapticLoop::render_wrench() {
  const Wrench<double> model = have_sample_ ? model_.at(middle_) : zero_wrench();
  const CouplingGains& gains = model_.model().gains;
  stored_ = {workspace_.linear_work() * spring_energy(model.force, gains.stiffness),
             workspace_.angular_work() * spring_energy(model.torque, gains.angular_stiffness)};
  record_.model = workspace_.to_arm(model);
  const double share = share_for(reading_);
  return {share * record_.model.force - passivity_.damping() * reading_.state.linear,
          share * record_.model.torque - angular_passivity_.damping() * reading_.state.angular};
}

// The chain of limits. Each stage keeps what the stages before it promised: a mix of two vectors within the limit is
// within the limit, and so are a step from one such vector towards another and a part of one.
Wrench<double> HapticLoop::apply_limits(const Wrench<double>& wanted) {
  if (!is_finite(wanted)) {
    fault_ = LoopFault::not_finite;
    record_.cut = true;
  }
  if (record_.cut) {
    slope_.forget();
    return zero_wrench();
  }

  const RigidState& device = reading_.state;
  WrenchLimits limits = config_.limits;
  // half of a force that the limit holds is half of the limit
  limits.force = share_for(reading_) * thermal_limit_.allowed(limits.force);
  limits.torque = share_for(reading_) * angular_thermal_limit_.allowed(limits.torque);
  const Wrench<double> damping{-config_.fade_damping * device.linear, -config_.fade_angular_damping * device.angular};
  const Wrench<double> kept = saturated(wanted, limits), fading = saturated(damping, limits);
  // past these speeds the coupling's spring is no more to be trusted; it comes back at four fifths of them
  const double margin = too_fast_ ? 0.8 : 1;
  too_fast_ = device.linear.norm() > margin * config_.safety.tool_speed ||
              device.angular.norm() > margin * config_.safety.tool_turn;
  const double g = too_fast_ ? 0 : record_.stale_scale, e = engagement_;
  const Wrench<double> mixed{e * (g * kept.force + (1 - g) * fading.force),
                             e * (g * kept.torque + (1 - g) * fading.torque)};
  // what is to end, to become less or to come back by and by does so without delay
  const bool less = e < 1 || g < 1 || limits.force < config_.limits.force || limits.torque < config_.limits.torque;
  if (less) slope_.forget();
  const Wrench<double> steady = slope_.step(last_sent_, mixed, config_.limits, period_);
  Wrench<double> sent = power_limited(steady, device, limits.power);
  slope_.note(mixed, sent);
  record_.reduced = sent.force != steady.force || sent.torque != steady.torque;
  const double share = share_for(reading_);
  rendered_ = {share * share_of(sent.force, wanted.force, e), share * share_of(sent.torque, wanted.torque, e)};
  return sent;
}

void HapticLoop::send(const Wrench<double>& wrench) {
  const bool finite = is_finite(wrench);
  if (!finite) fault_ = LoopFault::not_finite;
  record_.sent = finite ? wrench : zero_wrench();
  input_.was_written = device_.write(record_.sent);
  if (input_.was_written) {
    bad_writes_in_a_row_ = 0;
  } else {
    ++report_.bad_writes;
    if (++bad_writes_in_a_row_ > config_.max_bad_ticks) fault_ = LoopFault::device_write;
  }
  if (record_.cut && last_sent_.force.squaredNorm() + last_sent_.torque.squaredNorm() > 0) ++report_.cuts;
  last_sent_ = record_.sent;
  thermal_limit_.note(last_sent_.force.norm(), elapsed_);
  angular_thermal_limit_.note(last_sent_.torque.norm(), elapsed_);
}

// Fills in what the server, the log and the people get to know of this tick.
void HapticLoop::describe(std::int64_t now_ns) {
  const bool healthy = fault_ == LoopFault::none && record_.good_reading;
  const bool holds = healthy && reading_.engaged() && interlock_.held() && referenced_;
  sample_.flags = (healthy ? kHealthy : 0u) | (holds ? kEngaged : 0u) | ((reading_.buttons & 1u) ? kButton0 : 0u) |
                  ((reading_.buttons & 2u) ? kButton1 : 0u);
  sample_.t_device_ns = record_.good_reading ? now_ns : t_reading_ns_;
  sample_.pose = to_pose(tool_);
  sample_.twist = record_.good_reading ? to_twist(tool_) : TwistD{};
  sample_.gains = governor_.gains();

  if (fault_ != LoopFault::none) record_.state = LoopState::fault;
  record_.tick = ++report_.ticks;
  record_.device = reading_.state;
  record_.engaged_device = reading_.engaged();
  record_.alarms = reading_.alarms;
  record_.blend_linear = model_.model().blend_linear;
  record_.blend_angular = model_.model().blend_angular;
  record_.energy_linear = passivity_.energy();
  record_.energy_angular = angular_passivity_.energy();
  record_.damping_linear = passivity_.damping();
  record_.damping_angular = angular_passivity_.damping();
  record_.gains_share = governor_.share();

  if (report_.ticks == 1) report_.t_first_ns = now_ns;
  report_.t_last_ns = now_ns;
  report_.missed += record_.missed;
  report_.state = record_.state;
  report_.fault = fault_;
  report_.passed_over = gate_.passed_over();
  report_.verdicts = gate_.counts();
  report_.age_ns = record_.age_ns;
  report_.damped_ticks += passivity_.damping() > 0 || angular_passivity_.damping() > 0;
  report_.dead_man = reading_.dead_man;
  report_.powered = reading_.powered;
  report_.chain_closed = reading_.chain_closed;
  report_.shifted = reading_.shifted;
  report_.strained = reading_.strained;
  report_.gains_share = record_.gains_share;
  report_.reach = device_.info().reach && referenced_ ? workspace_.to_scene(*device_.info().reach) : SceneReach{};
  report_.force = record_.sent.force.norm();
  report_.torque = record_.sent.torque.norm();
  report_.peak_force = std::max(report_.peak_force, report_.force);
  report_.peak_torque = std::max(report_.peak_torque, report_.torque);
}

}  // namespace palp
