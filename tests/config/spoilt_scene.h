// A scene that uses every key there is, and what comes of reading one that is spoilt.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/error.h"
#include "config/scene_reader.h"

namespace palp::test {

// Uses every table and key there is. Lines are numbered in the comments, as the expected messages name them.
inline const std::string kScene = R"([scene]
name = "all"                            # 2
description = "every key"
method = "accurate"                     # 4
accuracy = "fast"
gravity = [0, 0, -9.81]                 # 6
body_force = [0.5, 0, 0]
gravity_ramp = 0.5                      # 8
rate_hz = 1000
duration = 2                            # 10
[domain]
min = [-1, -1, -1]                      # 12
max = [1, 1, 1]
periodic = [true, false, false]         # 14
[numerics]
spacing = {fast = 0.1, balanced = 0.05, accurate = 0.02}   # 16
support_over_spacing = 2.5
sound_speed = 40                        # 18
max_speed = 2
artificial_viscosity = 0.1              # 20
density_diffusion = 0.1
tension = false                         # 22
sub_steps = 4
safety = 0.4                            # 24
[stream]
particle_rate_hz = 30                   # 26
scalar = "density"
[[material]]                            # 28
name = "water"
density = 1000                          # 30
viscosity = 1e-3
color = "#102030"                       # 32
[[body]]
name = "pool"                           # 34
type = "fluid"
material = "water"                      # 36
temperature = 300
[[body.shape]]                          # 38
type = "box"
size = [1, 1, 0.5]                      # 40
[[body]]
name = "stick"                          # 42
type = "rigid"
material = "water"                      # 44
position = [0, 0, 0.8]
rotation_deg = {axis = [0, 0, 2], angle = 90}   # 46
velocity = [1, 0, 0]
angular_velocity = [0, 0, 1]            # 48
temperature = 310
color = "#ffffff"                       # 50
[[body.shape]]
type = "cylinder"                       # 52
radius = 0.1
height = 0.5                            # 54
orientation = [0, 0, 0, 1]
[[body.shape]]                          # 56
type = "mesh"
file = "parts/spoon.obj"                # 58
scale = 0.001
position = [0, 0, -0.1]                 # 60
rotation_deg = {axis = [1, 0, 0], angle = -30}
subtract = true                         # 62
[[proxy]]
device = 1                              # 64
body = "stick"
handle = [0, 0, 0.2]                    # 66
coupling_limit = {stiffness = 1, damping = 2, angular_stiffness = 3, angular_damping = 4}
[[probe]]                               # 68
name = "column"
quantity = "pressure"                   # 70
line = {from = [0, 0, -0.5], to = [0, 0, 0.5], count = 3}
rate_hz = 50                            # 72
[[probe]]
name = "front"                          # 74
quantity = "front"
body = "pool"                           # 76
axis = "y"
side = "min"                            # 78
[[probe]]
name = "spot"                           # 80
quantity = "velocity"
point = [0.5, 0, 0]                     # 82
[heat]
loss_to_air = 10                        # 84
air_temperature = 290
rate_hz = 25                            # 86
[[heat_zone]]
name = "flame"                          # 88
body = "stick"
position = [0, 0, -0.2]                 # 90
rotation_deg = {axis = [0, 0, 1], angle = 45}
size = [0.1, 0.2, 0.3]                  # 92
power = 500
start = 1                               # 94
end = 2
)";

inline SceneConfig read(const std::string& text, const SceneOverrides& overrides = {}) {
  TomlFile file = TomlFile::parse(text, "a/all.toml");
  SceneConfig scene = read_scene(file, "a/all.toml", overrides);
  file.finish();
  return scene;
}

inline std::vector<std::string> faults_of(const std::string& text, const SceneOverrides& overrides = {}) {
  try {
    read(text, overrides);
  } catch (const ConfigError& error) {
    return error.faults();
  }
  return {};
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace palp::test
