#include "haptic_bridge/device/profile.h"

#include <cmath>
#include <stdexcept>

#include "config/error.h"
#include "config/toml_reader.h"
#include "idl/coupling.h"

namespace palp {

namespace {

constexpr double kDegree = M_PI / 180;

// Fills value with the number under key, if there is a sound one.
void read(TomlTable& table, const char* key, const Range& range, double& value) {
  if (const auto number = table.number(key, range)) value = *number;
}

void read(TomlTable& table, const char* key, const Range& range, Eigen::Vector3d& value) {
  if (const auto n = table.numbers(key, 3, range)) value = {(*n)[0], (*n)[1], (*n)[2]};
}

void read_safety(TomlTable& root, SafetyConfig& safety) {
  TomlTable table = root.table("safety");
  if (const auto ms = table.number("overrun_ms", {"ms", 0, 1000})) safety.overrun_ns = std::llround(1e6 * *ms);
  if (const auto n = table.integer("late_ticks", 0, 1000)) safety.late_ticks = static_cast<int>(*n);
  if (const auto n = table.integer("bad_samples", 0, 1000)) safety.bad_samples = static_cast<int>(*n);
  read(table, "tool_speed", {"m/s", 0, 5, true}, safety.tool_speed);
  read(table, "tool_turn", {"rad/s", 0, 50, true}, safety.tool_turn);
}

void read_passivity(TomlTable& root, PassivityConfig& linear, PassivityConfig& angular) {
  TomlTable table = root.table("passivity");
  read(table, "device_damping", {"N s/m", 0, 100}, linear.device_damping);
  read(table, "most_damping", {"N s/m", 0, 100}, linear.most_damping);
  read(table, "start_energy", {"J", 0, 1}, linear.start);
  read(table, "most_energy", {"J", 0, 1}, linear.most);
  read(table, "angular_device_damping", {"N m s/rad", 0, 10}, angular.device_damping);
  read(table, "angular_most_damping", {"N m s/rad", 0, 10}, angular.most_damping);
  read(table, "angular_start_energy", {"J", 0, 1}, angular.start);
  read(table, "angular_most_energy", {"J", 0, 1}, angular.most);
}

// Where an axis of the arm points in the world: "+x", "-y", ...
Eigen::Vector3d direction(std::size_t choice) {
  return (choice % 2 == 0 ? 1 : -1) * Eigen::Vector3d::Unit(static_cast<int>(choice / 2));
}

void read_axes(TomlTable axes, Eigen::Matrix3d& m) {
  if (!axes.exists()) return;
  const char* const names[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    if (const auto choice = axes.choice(names[i], {"+x", "-x", "+y", "-y", "+z", "-z"}, Need::required))
      m.col(i) = direction(*choice);
  }
  double turn = 0;
  read(axes, "turn_deg", {"degrees", -180, 180}, turn);
  if (std::abs(m.determinant() - 1) > 1e-9) {
    axes.fault("",
               "the axes are no rotation; expected three different ones, right-handed, such as x = \"-y\", y = "
               "\"+x\", z = \"+z\"");
    m = default_arm_axes();
  }
  m = Eigen::AngleAxisd(kDegree * turn, Eigen::Vector3d::UnitZ()) * m;
}

void read_virtuose(TomlTable table, VirtuoseSetup& setup) {
  if (const auto text = table.text("library")) setup.library = *text;
  if (const auto text = table.text("address")) setup.address = *text;
  if (const auto choice = table.choice("mode", {"impedance", "virtmech"}))
    setup.mode = *choice == 0 ? VirtuoseMode::impedance : VirtuoseMode::mechanism;
  if (const auto type = table.integer("device_type", 1, 1000)) setup.device_type = static_cast<int>(*type);
  read(table, "relay_time", {"s", 0, 60}, setup.relay_time);
}

HandModel read_grip(TomlTable& root) {
  HandModel hand = kFirmGrip;
  if (root.is_table("grip")) {
    TomlTable grip = root.table("grip");
    read(grip, "mass", {"kg", 0, 10}, hand.mass);
    read(grip, "damping", {"N s/m", 0, 1000}, hand.damping);
    read(grip, "stiffness", {"N/m", 0, 1e4}, hand.stiffness);
    read(grip, "lever", {"m", 0.01, 0.5}, hand.lever);
  } else if (const auto choice = root.choice("grip", {"off", "light", "firm"})) {
    hand = *choice == 0 ? kHandsOff : *choice == 1 ? kLightGrip : kFirmGrip;
  }
  TomlTable tremor = root.table("tremor");
  read(tremor, "force", {"N rms", 0, 5}, hand.noise);
  if (const auto seed = tremor.integer("seed", 0, 1'000'000'000)) hand.seed = static_cast<std::uint64_t>(*seed);
  return hand;
}

Keyframe read_keyframe(TomlTable& table, const Keyframe* before) {
  Keyframe k;
  read(table, "time", {"s", 0, 86400}, k.time);
  if (!table.has("time")) table.fault("", "time is missing, expected seconds since the script began");
  if (const auto p = table.numbers("position", 3, {"m", -10, 10})) k.x = {(*p)[0], (*p)[1], (*p)[2]};
  if (const auto r = table.numbers("rotation_deg", 3, {"degrees", -180, 180})) {
    const Eigen::Vector3d turn = kDegree * Eigen::Vector3d((*r)[0], (*r)[1], (*r)[2]);
    if (turn.norm() > M_PI + 1e-9) table.fault("rotation_deg", "turns by more than 180 degrees, expected at most 180");
    k.q = rotation_by(turn);
  }
  if (before && k.time <= before->time) table.fault("time", "must be later than the keyframe before it");
  if (before && rotation_between(before->q, k.q).norm() >= kMaxCouplingAngle)
    table.fault("rotation_deg", "is more than 143 degrees from the keyframe before it; put a keyframe between them");
  return k;
}

}  // namespace

DeviceProfile read_device_profile(const std::string& path) {
  TomlFile file = TomlFile::read(path);
  TomlTable root = file.root();
  DeviceProfile profile;
  LoopConfig& loop = profile.loop;
  profile.name = root.text("name", Need::required).value_or("");

  TomlTable limits = root.table("limits", Need::required);
  read(limits, "force", {"N", 0, 200, true}, loop.limits.force);
  read(limits, "torque", {"N m", 0, 20, true}, loop.limits.torque);
  read(limits, "force_slew", {"N/s", 0, 1e5, true}, loop.limits.force_slew);
  read(limits, "torque_slew", {"N m/s", 0, 1e4, true}, loop.limits.torque_slew);
  read(limits, "axis_force", {"N", 0, 200, true}, loop.limits.axis_force);
  read(limits, "axis_torque", {"N m", 0, 20, true}, loop.limits.axis_torque);
  read(limits, "continuous_force", {"N", 0, 200, true}, loop.limits.continuous_force);
  read(limits, "continuous_torque", {"N m", 0, 20, true}, loop.limits.continuous_torque);
  read(limits, "power", {"W", 0, 1000, true}, loop.limits.power);

  TomlTable coupling = root.table("coupling");
  read(coupling, "stiffness", {"N/m", 0, 1e5}, loop.gains.stiffness);
  read(coupling, "damping", {"N s/m", 0, 1e4}, loop.gains.damping);
  read(coupling, "angular_stiffness", {"N m/rad", 0, 1e4}, loop.gains.angular_stiffness);
  read(coupling, "angular_damping", {"N m s/rad", 0, 1e3}, loop.gains.angular_damping);

  read_safety(root, loop.safety);
  read_passivity(root, loop.passivity, loop.angular_passivity);
  TomlTable workspace = root.table("workspace");
  read(workspace, "motion_scale", {"", 0.01, 100}, loop.workspace.motion_scale);
  read(workspace, "force_scale", {"", 0.01, 100}, loop.workspace.force_scale);
  if (const auto choice = workspace.choice("reference", {"absolute", "relative"}))
    loop.workspace.relative = *choice == 1;

  ArmModel& arm = profile.arm;
  TomlTable table = root.table("arm");
  read(table, "mass", {"kg", 0.01, 50}, arm.mass);
  read(table, "inertia", {"kg m^2", 1e-5, 10}, arm.inertia);
  read(table, "damping", {"N s/m", 0, 1000}, arm.damping);
  read(table, "angular_damping", {"N m s/rad", 0, 100}, arm.angular_damping);
  read(table, "friction", {"N", 0, 50}, arm.friction);
  read(table, "angular_friction", {"N m", 0, 5}, arm.angular_friction);
  read(table, "resolution", {"m", 0, 1e-3}, arm.resolution);
  read(table, "angular_resolution", {"rad", 0, 1e-2}, arm.angular_resolution);
  read(table, "velocity_filter_hz", {"Hz", 0, 1000}, arm.velocity_filter_hz);
  read(table, "force_limit", {"N", 0, 200, true}, arm.motors.force_limit);
  read(table, "torque_limit", {"N m", 0, 20, true}, arm.motors.torque_limit);
  read(table, "continuous_force", {"N", 0, 200, true}, arm.motors.continuous_force);
  read(table, "continuous_torque", {"N m", 0, 20, true}, arm.motors.continuous_torque);
  read(table, "workspace", {"m", 0, 5, true}, arm.workspace);
  if (const auto turn = table.number("turn_deg", {"degrees", 0, 180, true})) arm.turn = kDegree * *turn;

  read_axes(root.table("axes"), profile.virtuose.axes);
  TomlTable mouse = root.table("spacenav");
  if (const auto text = mouse.text("library")) profile.spacenav.library = *text;
  read(mouse, "speed", {"m/s", 0, 2, true}, profile.spacenav.speed);
  read(mouse, "turn", {"rad/s", 0, 10, true}, profile.spacenav.turn);
  profile.for_virtuose = root.is_table("virtuose");
  read_virtuose(root.table("virtuose"), profile.virtuose);
  file.finish();
  return profile;
}

HandScript read_hand_script(const std::string& path) {
  TomlFile file = TomlFile::read(path);
  TomlTable root = file.root();
  HandScript script;
  root.text("description");
  if (const auto choice = root.choice("interpolation", {"minimum_jerk", "catmull_rom"}))
    script.interpolation = *choice == 0 ? Interpolation::minimum_jerk : Interpolation::catmull_rom;
  script.loop = root.boolean("loop").value_or(false);
  script.hand = read_grip(root);
  for (TomlTable& table : root.tables("keyframe"))
    script.keyframes.push_back(read_keyframe(table, script.keyframes.empty() ? nullptr : &script.keyframes.back()));
  if (script.keyframes.empty() && !file.faulty())
    file.fault(0, "no [[keyframe]]; expected at least one, such as \"[[keyframe]]\\ntime = 0\"");
  file.finish();
  try {
    Trajectory(script.keyframes, script.interpolation, script.loop);
  } catch (const std::invalid_argument& error) {
    throw ConfigError(path + ": " + error.what());
  }
  return script;
}

}  // namespace palp
