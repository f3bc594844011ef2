// Scenes of one medium for tests of pictures, and how they get onto a stage.
#pragma once

#include <array>
#include <cmath>

#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/stage.h"

namespace palp::test {

// Shows the scene alone, seen from where its camera usually is.
inline void put_on(Stage& stage, const SyntheticScene& s, ScalarField field = ScalarField::none) {
  stage.hud().set_visible(false);
  set_scene(stage, s.scene);
  stage.scene().set_color(field);
  stage.scene().set_poses(s.poses);
  stage.scene().set_frame(s.frame);
  stage.go_home();
}

// A block of particles in the air, each displaced by up to so many spacings along each axis.
inline SyntheticScene block(const char* name, const std::array<int, 3>& sides = {14, 10, 6}, double displaced = 0) {
  SyntheticScene s = synthetic_scene();
  s.scene.bodies.resize(1);
  s.scene.bodies[0].color = {0.95f, 0.95f, 0.95f};
  make_look(s.scene.bodies[0], name);
  s.poses = {};
  s.frame.positions.clear();
  for (int i = 0; i < sides[0] * sides[1] * sides[2]; ++i) {
    const int at[3] = {i % sides[0], i / sides[0] % sides[1], i / (sides[0] * sides[1])};
    for (int a = 0; a < 3; ++a)
      s.frame.positions.push_back(static_cast<float>(kSpacing * (at[a] + displaced * std::sin(7919.0 * (3 * i + a)))));
  }
  const std::size_t count = s.frame.positions.size() / 3;
  s.frame.scalars.assign(count, 0.2f);
  s.scene.particle_count = s.scene.bodies[0].count = static_cast<std::uint32_t>(count);
  return s;
}

inline int largest_difference(const Picture& a, const Picture& b) {
  int most = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) most = std::max(most, std::abs(a.rgb[i] - b.rgb[i]));
  return most;
}

}  // namespace palp::test
