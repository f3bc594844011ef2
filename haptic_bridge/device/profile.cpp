#include "haptic_bridge/device/profile.h"

#include <cmath>

#include "haptic_bridge/device/drivers.h"

namespace palp {

void read_number(TomlTable& table, const char* key, const Range& range, double& value) {
  if (const auto number = table.number(key, range)) value = *number;
}

void read_number(TomlTable& table, const char* key, const Range& range, Eigen::Vector3d& value) {
  if (const auto n = table.numbers(key, 3, range)) value = {(*n)[0], (*n)[1], (*n)[2]};
}

namespace {

void read_safety(TomlTable& root, SafetyConfig& safety) {
  TomlTable table = root.table("safety");
  if (const auto ms = table.number("overrun_ms", {"ms", 0, 1000})) safety.overrun_ns = std::llround(1e6 * *ms);
  if (const auto n = table.integer("late_ticks", 0, 1000)) safety.late_ticks = static_cast<int>(*n);
  if (const auto n = table.integer("bad_samples", 0, 1000)) safety.bad_samples = static_cast<int>(*n);
  read_number(table, "tool_speed", {"m/s", 0, 5, true}, safety.tool_speed);
  read_number(table, "tool_turn", {"rad/s", 0, 50, true}, safety.tool_turn);
}

void read_passivity(TomlTable& root, PassivityConfig& linear, PassivityConfig& angular) {
  TomlTable table = root.table("passivity");
  read_number(table, "device_damping", {"N s/m", 0, 100}, linear.device_damping);
  read_number(table, "most_damping", {"N s/m", 0, 100}, linear.most_damping);
  read_number(table, "start_energy", {"J", 0, 1}, linear.start);
  read_number(table, "most_energy", {"J", 0, 1}, linear.most);
  read_number(table, "angular_device_damping", {"N m s/rad", 0, 10}, angular.device_damping);
  read_number(table, "angular_most_damping", {"N m s/rad", 0, 10}, angular.most_damping);
  read_number(table, "angular_start_energy", {"J", 0, 1}, angular.start);
  read_number(table, "angular_most_energy", {"J", 0, 1}, angular.most);
}

void read_limits(TomlTable limits, WrenchLimits& to) {
  read_number(limits, "force", {"N", 0, 200, true}, to.force);
  read_number(limits, "torque", {"N m", 0, 20, true}, to.torque);
  read_number(limits, "force_slew", {"N/s", 0, 1e5, true}, to.force_slew);
  read_number(limits, "torque_slew", {"N m/s", 0, 1e4, true}, to.torque_slew);
  read_number(limits, "axis_force", {"N", 0, 200, true}, to.axis_force);
  read_number(limits, "axis_torque", {"N m", 0, 20, true}, to.axis_torque);
  read_number(limits, "continuous_force", {"N", 0, 200, true}, to.continuous_force);
  read_number(limits, "continuous_torque", {"N m", 0, 20, true}, to.continuous_torque);
  read_number(limits, "power", {"W", 0, 1000, true}, to.power);
}

void read_coupling(TomlTable coupling, CouplingGains& gains) {
  read_number(coupling, "stiffness", {"N/m", 0, 1e5}, gains.stiffness);
  read_number(coupling, "damping", {"N s/m", 0, 1e4}, gains.damping);
  read_number(coupling, "angular_stiffness", {"N m/rad", 0, 1e4}, gains.angular_stiffness);
  read_number(coupling, "angular_damping", {"N m s/rad", 0, 1e3}, gains.angular_damping);
}

void read_workspace(TomlTable workspace, WorkspaceConfig& to) {
  read_number(workspace, "motion_scale", {"", 0.01, 100}, to.motion_scale);
  read_number(workspace, "force_scale", {"", 0.01, 100}, to.force_scale);
  if (const auto choice = workspace.choice("reference", {"absolute", "relative"})) to.relative = *choice == 1;
}

}  // namespace

DeviceProfile read_device_profile(const std::string& path) {
  TomlFile file = TomlFile::read(path);
  TomlTable root = file.root();
  DeviceProfile profile;
  LoopConfig& loop = profile.loop;
  profile.name = root.text("name", Need::required).value_or("");

  read_limits(root.table("limits", Need::required), loop.limits);
  read_coupling(root.table("coupling"), loop.gains);
  read_safety(root, loop.safety);
  read_passivity(root, loop.passivity, loop.angular_passivity);
  read_workspace(root.table("workspace"), loop.workspace);
  for (const Driver& driver : drivers())
    if (driver.read_profile) driver.read_profile(root, profile);
  file.finish();
  return profile;
}

}  // namespace palp
