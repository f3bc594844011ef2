#include "haptic_bridge/device/simulated.h"

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "haptic_bridge/loop/force_limits.h"
#include "idl/coupling.h"

namespace palp {

namespace {

using Vec3 = Eigen::Vector3d;
using Quat = Eigen::Quaterniond;

constexpr double kSubStep = 0.25e-3;           // [s]
constexpr double kLongestGap = 0.1;            // after a longer pause of the loop the arm's time stood still [s]
constexpr double kApproachSpeed = 0.1;         // [m/s], mean
constexpr double kApproachTurn = 1.0;          // [rad/s], mean
constexpr double kBristleReach = 20e-6;        // friction yields after this much [m]: less than a hand can notice
constexpr double kAngularReach = 4e-4;         // [rad]
constexpr double kStopStiffness = 2e4;         // [N/m]
constexpr double kStopTurnStiffness = 100;     // [N m/rad]
constexpr double kTremorRate = 2 * M_PI * 10;  // [rad/s]
constexpr double kTremorDamping = 0.2;

Keyframe from_home(const RigidState& home, const Keyframe& offset, double time) {
  return {time, home.position + offset.x, (offset.q * home.orientation).normalized()};
}

Trajectory make_script(const HandScript& script, const RigidState& home) {
  std::vector<Keyframe> path;
  for (const Keyframe& k : script.keyframes) path.push_back(from_home(home, k, k.time - script.keyframes.front().time));
  if (path.empty()) path.push_back(from_home(home, {}, 0));
  return Trajectory(std::move(path), script.interpolation, script.loop);
}

// Returns the path from where the handle is to where the script begins; it has no length when the handle is there
// already.
Trajectory make_approach(const RigidState& start, const Keyframe& first) {
  const double distance = (first.x - start.position).norm(),
               angle = rotation_between(start.orientation, first.q).norm();
  std::vector<Keyframe> path{{0, start.position, start.orientation}};
  if (distance > 1e-3 || angle > 0.01) {
    const double time = std::max({1.0, distance / kApproachSpeed, angle / kApproachTurn});
    if (angle > 2) path.push_back({time / 2, (start.position + first.x) / 2, start.orientation.slerp(0.5, first.q)});
    path.push_back({time, first.x, first.q});
  }
  return Trajectory(std::move(path), Interpolation::minimum_jerk, false);
}

// Coulomb friction that truly holds at rest: a stiff bristle that is dragged along once it has yielded (Dahl 1968, with
// the bristle's own damping as in LuGre). Returns the force on what moves; its length never exceeds friction.
Vec3 friction_force(Vec3& bristle, const Vec3& velocity, double friction, double reach, double mass, double dt) {
  if (friction <= 0) return Vec3::Zero();
  const double stiffness = friction / reach;
  const Vec3 before = bristle;
  bristle = saturated(Vec3(bristle + velocity * dt), reach);
  const Vec3 rate = (bristle - before) / dt;
  return saturated(Vec3(-stiffness * bristle - std::sqrt(stiffness * mass) * rate), friction);
}

// The exact effect of a constant force F and a viscous friction on a mass m within dt: v' = decay v + reach F / m and
// x' = x + reach v + way F / m. hold() takes the rate of the friction: its coefficient over the mass [1/s].
struct Hold {
  double decay, reach, way;
};

Hold hold(double dt, double rate) {
  const double a = rate * dt;
  // the closed form loses its digits where a is small
  const double reach = a < 1e-3 ? dt * (1 - a / 2 * (1 - a / 3)) : -std::expm1(-a) / rate;
  const double way = a < 1e-3 ? dt * dt / 2 * (1 - a / 3 * (1 - a / 4)) : (dt - reach) / rate;
  return {1 - rate * reach, reach, way};
}

Quat turned(const Quat& q, const Vec3& by) { return (rotation_by(by) * q).normalized(); }

double rounded(double value, double step) { return step > 0 ? std::round(value / step) * step : value; }

// The springs act as they are in the middle of a step (leapfrog), so only these limit it.
void check_stable(const char* what, double mass, double stiffness) {
  if (!(mass > 0)) throw ConfigError(std::string("simulated device: its ") + what + " must be above zero");
  if (stiffness * kSubStep * kSubStep / mass > 1)
    throw ConfigError(
        std::string("simulated device: its ") + what +
        " is too small for the stiffness of hand and friction at the device's time step of 0.25 ms: raise "
        "the mass or inertia, or lower the stiffness or friction");
}

DeviceInfo info_of(const ArmModel& arm, const RigidState& home) {
  DeviceInfo info{"simulated arm", arm.motors.force_limit, arm.motors.torque_limit, true};
  if (arm.workspace.maxCoeff() < ArmModel::kNoStop) info.reach = DeviceReach{home.position, arm.workspace};
  return info;
}

}  // namespace

SimulatedDevice::SimulatedDevice(const ArmModel& arm, const HandScript& script, const RigidState& home,
                                 const RigidState& start)
    : arm_(arm),
      hand_(script.hand),
      approach_(make_approach(start, make_script(script, home).keyframes().front())),
      script_(make_script(script, home)),
      info_(info_of(arm, home)),
      state_{start.position, start.orientation.normalized(), Vec3::Zero(), Vec3::Zero()},
      home_(home),
      commanded_(zero_wrench()),
      applied_(zero_wrench()),
      measured_(state_),
      random_(script.hand.seed) {
  const double lever2 = hand_.lever * hand_.lever;
  check_stable("mass", arm.mass, hand_.stiffness + arm.friction / kBristleReach);
  check_stable("inertia", arm.inertia, hand_.stiffness * lever2 + arm.angular_friction / kAngularReach);
}

RigidState SimulatedDevice::intent(double time) const noexcept {
  return time < approach_.duration() ? approach_.at(time) : script_.at(time - approach_.duration());
}

bool SimulatedDevice::read(std::int64_t now_ns, DeviceReading& out) noexcept {
  if (!started_) {
    started_ = true;
    t_last_ns_ = now_ns;
    measure(0);
  }
  const double dt = std::clamp(1e-9 * static_cast<double>(now_ns - t_last_ns_), 0.0, kLongestGap);
  t_last_ns_ = now_ns;
  if (dt > 0) {
    advance(dt);
    measure(dt);
  }
  out.state = measured_;
  out.dead_man = grip_.holds(now_ns);
  out.powered = out.chain_closed = true;
  out.alarms =
      (at_stop_ ? kArmAtStop : 0u) | (motors_.hot() ? kArmHot : 0u) | (motors_.overloaded() ? kArmSaturated : 0u);
  out.strained = out.alarms != 0;
  out.buttons = 0;
  return true;
}

bool SimulatedDevice::write(const Wrench<double>& wrench) noexcept {
  if (!is_finite(wrench)) return false;
  commanded_ = wrench;
  return true;
}

void SimulatedDevice::advance(double dt) noexcept {
  applied_ = motors_.render(commanded_, arm_.motors, dt);
  at_stop_ = false;
  const int steps = std::max(1, static_cast<int>(std::ceil(dt / kSubStep - 1e-6)));
  for (int i = 0; i < steps; ++i) sub_step(time_ + dt * (i + 0.5) / steps, dt / steps);
  time_ += dt;
}

// The wrench of the loop is held over the step, and place and speed follow it exactly: so a spring that the loop
// renders meets the bounds that theory gives for a held force.
void SimulatedDevice::sub_step(double middle, double dt) noexcept {
  const RigidState wish = intent(middle);
  const double lever2 = hand_.lever * hand_.lever;

  const double mass = arm_.mass + hand_.mass;
  const Hold linear = hold(dt, (hand_.damping + arm_.damping) / mass);
  const Vec3 force =
      applied_.force + hand_.stiffness * (wish.position - (state_.position + dt / 2 * state_.linear)) +
      hand_.damping * wish.linear + tremor(dt) +
      stop_force(state_.position - home_.position, state_.linear, arm_.workspace, kStopStiffness, arm_.mass) +
      friction_force(bristle_, state_.linear, arm_.friction, kBristleReach, arm_.mass, dt);
  state_.position += linear.reach * state_.linear + linear.way / mass * force;
  state_.linear = linear.decay * state_.linear + linear.reach / mass * force;

  const double inertia = arm_.inertia + hand_.mass * lever2;
  const Hold angular = hold(dt, (lever2 * hand_.damping + arm_.angular_damping) / inertia);
  const Quat q_middle = turned(state_.orientation, dt / 2 * state_.angular);
  const Vec3 torque =
      applied_.torque + lever2 * hand_.stiffness * rotation_between(q_middle, wish.orientation) +
      lever2 * hand_.damping * wish.angular +
      stop_force(rotation_between(home_.orientation, state_.orientation), state_.angular, Vec3::Constant(arm_.turn),
                 kStopTurnStiffness, arm_.inertia) +
      friction_force(angular_bristle_, state_.angular, arm_.angular_friction, kAngularReach, arm_.inertia, dt);
  state_.orientation = turned(state_.orientation, angular.reach * state_.angular + angular.way / inertia * torque);
  state_.angular = angular.decay * state_.angular + angular.reach / inertia * torque;
}

// Returns the force of the stops on the arm, along each axis: a stiff spring that is damped on the way in and lets go
// on the way out.
Vec3 SimulatedDevice::stop_force(const Vec3& from_home, const Vec3& velocity, const Vec3& reach, double stiffness,
                                 double mass) noexcept {
  Vec3 force = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double side = from_home[i] < 0 ? -1 : 1, past = side * from_home[i] - reach[i];
    if (past <= 0) continue;
    at_stop_ = true;
    force[i] = -side * std::max(0.0, stiffness * past + std::sqrt(stiffness * mass) * side * velocity[i]);
  }
  return force;
}

// Returns the force of the hand's tremor: a resonance at 10 Hz driven by white noise, scaled to the wanted rms.
Vec3 SimulatedDevice::tremor(double dt) noexcept {
  if (hand_.noise <= 0) return Vec3::Zero();
  const double kick = hand_.noise * std::sqrt(4 * kTremorDamping * kTremorRate * kTremorRate * kTremorRate * dt);
  for (int i = 0; i < 3; ++i) {
    tremor_v_[i] += kick * normal_(random_) -
                    dt * (kTremorRate * kTremorRate * tremor_x_[i] + 2 * kTremorDamping * kTremorRate * tremor_v_[i]);
    tremor_x_[i] += dt * tremor_v_[i];
  }
  return tremor_x_;
}

// Sets the measured state to what the encoders show, with the velocity that a controller makes of it.
void SimulatedDevice::measure(double dt) noexcept {
  const RigidState before = measured_;
  for (int i = 0; i < 3; ++i) measured_.position[i] = rounded(state_.position[i], arm_.resolution);
  for (int i = 0; i < 4; ++i)
    measured_.orientation.coeffs()[i] = rounded(state_.orientation.coeffs()[i], arm_.angular_resolution / 2);
  measured_.orientation.normalize();
  if (dt <= 0) return;
  if (arm_.velocity_filter_hz <= 0) {
    measured_.linear = state_.linear;
    measured_.angular = state_.angular;
    return;
  }
  const double share = low_pass_share(arm_.velocity_filter_hz, dt);
  measured_.linear += share * ((measured_.position - before.position) / dt - measured_.linear);
  measured_.angular += share * (rotation_between(before.orientation, measured_.orientation) / dt - measured_.angular);
}

namespace {

void read_arm(TomlTable& root, DeviceProfile& profile) {
  ArmModel& arm = profile.setup<ArmModel>();
  TomlTable table = root.table("arm");
  read_number(table, "mass", {"kg", 0.01, 50}, arm.mass);
  read_number(table, "inertia", {"kg m^2", 1e-5, 10}, arm.inertia);
  read_number(table, "damping", {"N s/m", 0, 1000}, arm.damping);
  read_number(table, "angular_damping", {"N m s/rad", 0, 100}, arm.angular_damping);
  read_number(table, "friction", {"N", 0, 50}, arm.friction);
  read_number(table, "angular_friction", {"N m", 0, 5}, arm.angular_friction);
  read_number(table, "resolution", {"m", 0, 1e-3}, arm.resolution);
  read_number(table, "angular_resolution", {"rad", 0, 1e-2}, arm.angular_resolution);
  read_number(table, "velocity_filter_hz", {"Hz", 0, 1000}, arm.velocity_filter_hz);
  read_number(table, "force_limit", {"N", 0, 200, true}, arm.motors.force_limit);
  read_number(table, "torque_limit", {"N m", 0, 20, true}, arm.motors.torque_limit);
  read_number(table, "continuous_force", {"N", 0, 200, true}, arm.motors.continuous_force);
  read_number(table, "continuous_torque", {"N m", 0, 20, true}, arm.motors.continuous_torque);
  read_number(table, "workspace", {"m", 0, 5, true}, arm.workspace);
  if (const auto turn = table.number("turn_deg", {"degrees", 0, 180, true})) arm.turn = kDegree * *turn;
}

void read_hand(DeviceRequest& request) {
  const std::string hand = request.option("--hand");
  if (!hand.empty()) request.profile.setup<HandScript>() = read_hand_script(find_hand_file(hand));
}

}  // namespace

Driver simulated_driver() {
  return {.name = "simulated",
          .what = "an arm in a scripted hand",
          .needs = "",
          .options = {{"--hand", "NAME",
                       "what the hand does: a TOML file, or the name of one in config/hands; without it the hand holds "
                       "still"}},
          .starts_in_scene = true,
          .read_profile = read_arm,
          .prepare = read_hand,
          .open = [](const DeviceRequest& request, const HandleStart& start) -> std::unique_ptr<HapticDevice> {
            return std::make_unique<SimulatedDevice>(request.profile.setup<ArmModel>(),
                                                     request.profile.setup<HandScript>(), start.home, start.at);
          },
          .power_off = nullptr};
}

}  // namespace palp
