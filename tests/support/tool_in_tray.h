// The tray of the demo with its tool in the oil.
#pragma once

#include <vector>

#include "config/scene_config.h"
#include "tests/support/scene_files.h"

namespace palp::test {

// Returns the scene with the middle of its tool's bowl at the height z [m], where the oil has a hole for the tool.
inline SceneConfig tool_in_tray(Accuracy accuracy, double z) {
  SceneOverrides overrides;
  overrides.accuracy = accuracy;
  SceneConfig config = load_scene(source_file("config/scenes/tray_fluid.toml"), overrides);
  std::vector<ShapeConfig> holes;
  for (BodyConfig& body : config.bodies) {
    if (body.type != BodyKind::rigid) continue;
    body.position.z() = z;
    for (ShapeConfig hole : body.shapes) {
      hole.position += body.position;
      hole.subtract = true;
      holes.push_back(hole);
    }
  }
  for (BodyConfig& body : config.bodies) {
    if (body.type != BodyKind::fluid) continue;
    for (ShapeConfig& hole : holes) hole.position -= body.position;
    body.shapes.insert(body.shapes.end(), holes.begin(), holes.end());
  }
  return config;
}

}  // namespace palp::test
