#include "haptic_bridge/device/fake_virtuose/script.h"

#include <filesystem>
#include <limits>

#include "config/toml_reader.h"
#include "haptic_bridge/device/profile.h"

namespace palp::fake {

namespace {

const std::vector<std::string> kEventNames{"dead_man_up",    "power_off", "emergency_stop", "shift", "button",
                                           "bound",          "alarm",     "failure",        "error", "nan_position",
                                           "bad_quaternion", "jump",      "freeze",         "slow"};

void read(TomlTable& table, const char* key, const Range& range, double& value) {
  if (const auto number = table.number(key, range)) value = *number;
}

void read(TomlTable& table, const char* key, long long min, long long max, int& value) {
  if (const auto number = table.integer(key, min, max)) value = static_cast<int>(*number);
}

Event read_event(TomlTable& table) {
  Event event;
  if (const auto kind = table.choice("event", kEventNames, Need::required)) event.kind = static_cast<EventKind>(*kind);
  read(table, "time", {"s", 0, 86400}, event.time);
  event.end = std::numeric_limits<double>::infinity();
  if (const auto duration = table.number("duration", {"s", 0, 86400, true})) event.end = event.time + *duration;
  read(table, "value", {"", -1e9, 1e9}, event.value);
  event.call = table.text("call").value_or("");
  return event;
}

}  // namespace

Script read_script(const std::string& path) {
  TomlFile file = TomlFile::read(path);
  TomlTable root = file.root();
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const auto beside = [&](const std::optional<std::string>& name) {
    return name ? (folder / *name).string() : std::string();
  };
  Script script;
  script.lock_step = root.choice("clock", {"real", "lock_step"}).value_or(0) == 1;
  read(root, "device_type", 1, 1000, script.device_type);
  read(root, "serial", 0, 1'000'000, script.serial);
  read(root, "major_version", 0, 1000, script.major_version);
  read(root, "minor_version", 0, 1000, script.minor_version);
  read(root, "relay_delay", {"s", 0, 60}, script.relay_delay);
  read(root, "latency", {"s", 0, 0.1}, script.latency);
  read(root, "grip_at", {"s", 0, 86400}, script.grip_at);
  script.regrip = root.boolean("regrip").value_or(script.regrip);
  read(root, "continuous_force", {"N", 0, 200, true}, script.continuous_force);
  read(root, "continuous_torque", {"N m", 0, 20, true}, script.continuous_torque);
  if (const auto sizes = root.numbers("workspace", 3, {"m", 0.01, 10})) script.workspace = *sizes;
  script.log = beside(root.text("log"));
  script.trace = beside(root.text("trace"));
  const std::string hand = beside(root.text("hand")), profile = beside(root.text("profile"));
  for (TomlTable& table : root.tables("event")) script.events.push_back(read_event(table));
  file.finish();
  if (!hand.empty()) script.hand = read_hand_script(hand);
  if (!profile.empty()) script.arm = read_device_profile(profile).setup<ArmModel>();
  return script;
}

}  // namespace palp::fake
