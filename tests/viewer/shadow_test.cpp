// Shadows in pictures of scenes that are made from formulas.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/stage.h"

namespace palp::test::shadow_test {
namespace {

BodyDescription box(const char* name, std::array<double, 3> low, std::array<double, 3> high) {
  BodyDescription body;
  body.name = name;
  body.kind = BodyKind::fixed;
  body.color = {0.8f, 0.8f, 0.8f};
  add_box(body, low, high, true, true);
  return body;
}

// A table, and a block of dough or a solid one that hovers 6 cm above its middle, or nothing.
SceneDescription table_with(const char* above) {
  SceneDescription scene;
  scene.spacing = 0.005;
  scene.bounds_min = {-0.3, -0.3, -0.1};
  scene.bounds_max = {0.3, 0.3, 0.3};
  scene.bodies = {box("table", {-0.2, -0.2, -0.02}, {0.2, 0.2, 0})};
  if (std::string(above) == "block") scene.bodies.push_back(box("block", {-0.03, -0.03, 0.06}, {0.03, 0.03, 0.09}));
  if (std::string(above) == "dough") {
    BodyDescription dough;
    dough.name = "dough";
    dough.density = 1000;
    dough.color = {0.8f, 0.8f, 0.8f};
    dough.count = 12 * 12 * 6;
    scene.bodies.push_back(dough);
    scene.particle_count = dough.count;
  }
  return scene;
}

ParticleFrame dough_frame() {
  ParticleFrame frame;
  for (int i = 0; i < 12 * 12 * 6; ++i) {
    const int row = i / 12 % 12, layer = i / 144;
    for (const double x : {-0.0275 + 0.005 * (i % 12), -0.0275 + 0.005 * row, 0.0625 + 0.005 * layer})
      frame.positions.push_back(static_cast<float>(x));
  }
  return frame;
}

Picture picture_of(const char* above, osg::Vec2d* shaded, osg::Vec2d* lit) {
  Stage stage(small_stage(640, 480));
  stage.hud().set_visible(false);
  set_scene(stage, table_with(above));
  if (std::string(above) == "dough") stage.scene().set_frame(dough_frame());
  stage.go_home();
  Picture picture = shoot(stage);
  // where the key light (lighting.glsl) throws the middle of what hovers, and its mirror image
  const double run = 0.06 / 0.76;
  *shaded = stage.project({0.42 * run, 0.50 * run, 0});
  *lit = stage.project({-0.12, -0.12, 0});
  return picture;
}

TEST(Shadow, WhatHoversThrowsOneOnTheTable) {
  for (const char* above : {"nothing", "block", "dough"}) {
    osg::Vec2d shaded, lit;
    const Picture picture = picture_of(above, &shaded, &lit);
    const int there = at(picture, shaded).g, elsewhere = at(picture, lit).g;
    if (std::string(above) == "nothing") {
      EXPECT_NEAR(there, elsewhere, 3) << "a flat table is lit evenly";
    } else {
      EXPECT_LT(there, elsewhere - 40) << above;
    }
  }
}

// A surface must not shade itself: no specks on a table that nothing stands on.
TEST(Shadow, ALitTableHasNoSpecks) {
  osg::Vec2d middle, lit;
  const Picture picture = picture_of("nothing", &middle, &lit);
  const Pixel first = at(picture, lit);
  for (int y = -30; y <= 30; ++y) {
    for (int x = -30; x <= 30; ++x) EXPECT_NEAR(at(picture, middle + osg::Vec2d(x, y)).g, first.g, 4) << x << ' ' << y;
  }
}

}  // namespace
}  // namespace palp::test::shadow_test
