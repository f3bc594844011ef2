#include "haptic_bridge/device/hand_script.h"

#include <cmath>
#include <stdexcept>

#include "config/data_dir.h"
#include "config/error.h"
#include "config/toml_reader.h"
#include "haptic_bridge/device/profile.h"

namespace palp {

namespace {

HandModel read_grip(TomlTable& root) {
  HandModel hand = kFirmGrip;
  if (root.is_table("grip")) {
    TomlTable grip = root.table("grip");
    read_number(grip, "mass", {"kg", 0, 10}, hand.mass);
    read_number(grip, "damping", {"N s/m", 0, 1000}, hand.damping);
    read_number(grip, "stiffness", {"N/m", 0, 1e4}, hand.stiffness);
    read_number(grip, "lever", {"m", 0.01, 0.5}, hand.lever);
  } else if (const auto choice = root.choice("grip", {"off", "light", "firm"})) {
    hand = *choice == 0 ? kHandsOff : *choice == 1 ? kLightGrip : kFirmGrip;
  }
  TomlTable tremor = root.table("tremor");
  read_number(tremor, "force", {"N rms", 0, 5}, hand.noise);
  if (const auto seed = tremor.integer("seed", 0, 1'000'000'000)) hand.seed = static_cast<std::uint64_t>(*seed);
  return hand;
}

Keyframe read_keyframe(TomlTable& table, const Keyframe* before) {
  Keyframe k;
  read_number(table, "time", {"s", 0, 86400}, k.time);
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

std::string find_hand_file(const std::string& name) { return find_data_file(kHandFiles, name); }

}  // namespace palp
