#include "haptic_bridge/device/fake_virtuose/arm.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_bridge/loop/force_limits.h"
#include "haptic_bridge/loop/local_model.h"

namespace palp::fake {

namespace {

using Vec3 = Eigen::Vector3d;
using Quat = Eigen::Quaterniond;

constexpr double kTick = 1e-3;          // [s]
constexpr double kSaturatedFor = 0.02;  // the alarm stays so long [s]
constexpr double kRegripAfter = 2, kLetGoFor = 0.3;
constexpr double kTurnLimit = 2.0;  // of each axis of the wrist [rad]

// Where the handle begins, room: at no special place, so that nothing rests on one.
RigidState home() {
  return at_rest({0.05, -0.02, 0.3}, Quat(Eigen::AngleAxisd(0.35, Vec3(0.2, 1, -0.5).normalized())));
}

Vec3 to_arm(const Vec3& room) { return {-room.y(), room.x(), room.z()}; }
Vec3 to_room(const Vec3& arm) { return {arm.y(), -arm.x(), arm.z()}; }
Quat to_arm(const Quat& q) { return Quat(q.w(), -q.y(), q.x(), q.z()); }

Pose pose_of(const Vec3& x, const Quat& q) {
  const auto f = [](double v) { return static_cast<float>(v); };
  return {f(x.x()), f(x.y()), f(x.z()), f(q.x()), f(q.y()), f(q.z()), f(q.w())};
}
Vector vector_of(const Vec3& a, const Vec3& b) {
  const auto f = [](double v) { return static_cast<float>(v); };
  return {f(a.x()), f(a.y()), f(a.z()), f(b.x()), f(b.y()), f(b.z())};
}
Vec3 linear(const Vector& v) { return {v[0], v[1], v[2]}; }
Vec3 angular(const Vector& v) { return {v[3], v[4], v[5]}; }
Vec3 place(const Pose& p) { return {p[0], p[1], p[2]}; }
Quat turn(const Pose& p) { return Quat(p[6], p[3], p[4], p[5]).normalized(); }

// Its motors are the controller's (Arm::limited), which also knows the limits that a client sets.
Script with_plain_motors(Script script) {
  script.arm.motors.continuous_force = script.arm.motors.continuous_torque = std::numeric_limits<double>::infinity();
  // the script's axes are the arm's
  script.arm.workspace = {script.workspace[1], script.workspace[0], script.workspace[2]};
  return script;
}

std::unique_ptr<SimulatedDevice> hand_at_rest(const Script& script) {
  HandScript still = script.hand;
  still.keyframes.clear();
  still.loop = false;
  return std::make_unique<SimulatedDevice>(script.arm, still, home(), home());
}

}  // namespace

Arm::Arm(const Script& script) : script_(with_plain_motors(script)), plant_(hand_at_rest(script_)), state_(home()) {
  if (!script.trace.empty()) {
    trace_.open(script.trace);
    trace_ << "time,dead_man,powered,chain_closed,shifted,alarms,fx,fy,fz,tx,ty,tz\n";
  }
  measure();
}

bool Arm::is_on(EventKind kind, double* value) const {
  for (const Event& event : script_.events) {
    if (event.kind != kind || !event.holds(time())) continue;
    if (value) *value = event.value;
    return true;
  }
  return false;
}

void Arm::advance_to(double t) {
  while (time() + kTick / 2 < t) step();
}

void Arm::step() {
  ++ticks_;
  follow_switches();
  follow_hand();
  // over the step that ends now
  while (!underway_.empty() && time() - kTick - underway_.front().time >= script_.latency - kTick / 2) {
    active_ = underway_.front();
    underway_.pop_front();
  }
  rendered_ = limited(wanted_force());
  plant_->write({to_room(linear(rendered_)), to_room(angular(rendered_))});
  plant_->show(LoopState::engaged);
  DeviceReading reading;
  plant_->read(ticks_ * 1'000'000, reading);
  state_ = reading.state;
  if (!is_on(EventKind::freeze)) measure();
  trace();
}

void Arm::follow_switches() {
  if (!chain_closed()) power_wanted = false;
  const bool on = power_wanted && !is_on(EventKind::power_off);
  if (on && !powered_) t_power_ = time();
  powered_ = on;
}

void Arm::follow_hand() {
  const double since = time() - t_hold_;
  const bool was = holds_;
  if (!holds_) {
    holds_ = t_hold_ > 0 ? since >= kLetGoFor : time() >= script_.grip_at;
  } else if (script_.regrip && !felt_ && since >= kRegripAfter) {
    holds_ = false;
  }
  if (holds_ != was) {
    t_hold_ = time();
    felt_ = false;
  }
  if (rendered_ != Vector{}) felt_ = true;
  const bool begins = script_.regrip ? felt_ : holds_;
  if (begins && !moving_ && !script_.hand.keyframes.empty()) {
    plant_ = std::make_unique<SimulatedDevice>(script_.arm, script_.hand, home(), plant_->true_state());
    DeviceReading first;
    plant_->read((ticks_ - 1) * 1'000'000, first);
  }
  moving_ = moving_ || begins;
}

// In the arm's frame, on the hand.
Vector Arm::wanted_force() const {
  const Vec3 more = linear(active_.more), more_torque = angular(active_.more);
  if (mode == kVirtImpedance) return vector_of(linear(active_.force) + more, angular(active_.force) + more_torque);
  if (mode != kVirtMechanism || !attached) return {};
  const Vec3 x = place(shown_.avatar), v = linear(shown_.speed), w = angular(shown_.speed);
  const Quat q = turn(shown_.avatar);
  // these gains are given rotation first
  const Vec3 kt = angular(stiffness), kr = linear(stiffness), bt = angular(damping), br = linear(damping);
  return vector_of(
      more + kt.cwiseProduct(place(active_.target) - x) + bt.cwiseProduct(linear(active_.target_speed) - v),
      more_torque + kr.cwiseProduct(rotation_between(q, turn(active_.target))) +
          br.cwiseProduct(angular(active_.target_speed) - w));
}

Vector Arm::limited(Vector force) {
  const bool renders = feedback && powered_ && dead_man() && time() - t_power_ >= script_.relay_delay;
  if (!renders) force = {};
  const MotorRating rating{std::min(force_limit, script_.arm.motors.force_limit),
                           std::min(torque_limit, script_.arm.motors.torque_limit), script_.continuous_force,
                           script_.continuous_torque};
  const Wrench<double> w = motors_.render({linear(force), angular(force)}, rating, kTick);
  if (motors_.overloaded()) t_saturated_ = time();
  return vector_of(w.force, w.torque);
}

// While the power or the dead-man switch is off or the shift button is pressed, the arm moves and its avatar does not.
void Arm::measure() {
  const Vec3 x = to_arm(state_.position);
  const Quat q = to_arm(state_.orientation);
  const bool indexing = shifted() || !dead_man();
  if (indexing || indexing_) {  // the offset that leaves the avatar where it is
    x_offset_ = place(shown_.avatar) - x;
    q_offset_ = turn(shown_.avatar) * q.conjugate();
  }
  if (ticks_ == 0) x_offset_.setZero(), q_offset_.setIdentity();
  indexing_ = indexing;
  t_measured_ = ticks_;
  shown_ = {pose_of(x + x_offset_, (q_offset_ * q).normalized()), pose_of(x, q),
            vector_of(to_arm(state_.linear), to_arm(state_.angular))};
}

void Arm::trace() {
  if (!trace_.is_open()) return;
  trace_ << time() << ',' << dead_man() << ',' << powered_ << ',' << chain_closed() << ',' << shifted() << ','
         << (alarms() | bounds());
  for (const float v : rendered_) trace_ << ',' << v;
  trace_ << '\n';
}

unsigned Arm::bounds() const {
  double value = 0;
  unsigned bits = is_on(EventKind::bound, &value) ? bits_of(value) : 0;
  const Vec3 since = to_arm(Vec3(state_.position - home().position));
  const Vec3 turned = to_arm(rotation_between(home().orientation, state_.orientation));
  // one bit for each side of each axis; the axes of a real arm are its joints
  for (int i = 0; i < 3; ++i) {
    const double reach = script_.workspace[static_cast<std::size_t>(i)];
    if (since[i] > reach) bits |= 0x1u << (2 * i);
    if (since[i] < -reach) bits |= 0x2u << (2 * i);
    if (turned[i] > kTurnLimit) bits |= 0x40u << (2 * i);
    if (turned[i] < -kTurnLimit) bits |= 0x80u << (2 * i);
  }
  return bits;
}

unsigned Arm::alarms() const {
  double value = 0;
  unsigned bits = is_on(EventKind::alarm, &value) ? bits_of(value) : 0;
  if (motors_.hot()) bits |= kVirtOverheat;
  if (t_saturated_ >= 0 && time() - t_saturated_ < kSaturatedFor) bits |= kVirtSaturated;
  return bits;
}

Command& Arm::next_command() {
  underway_.push_back(underway_.empty() ? active_ : underway_.back());
  underway_.back().time = time();
  return underway_.back();
}

void Arm::send(const Vector& force) {
  Command& command = next_command();
  command.force = force;
  command.more = {};
}

void Arm::add(const Vector& force) { next_command().more = force; }

void Arm::send_target(const Pose* pose, const Vector* speed) {
  Command& command = next_command();
  if (pose) command.target = *pose;
  if (speed) command.target_speed = *speed;
}

void Arm::attach() {
  if (!underway_.empty()) active_ = underway_.back();
  underway_.clear();
  attached = true;
}

void Arm::cut() {
  active_ = {};
  underway_.clear();
  power_wanted = false;
  attached = false;
}

}  // namespace palp::fake
