// Scenes that are cut open: what lies beyond the plane is gone from surfaces, particles and shadows.
#include <gtest/gtest.h>

#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"

namespace palp::test::reading_image_test {
namespace {

SceneDescription red_box() {
  SceneDescription scene;
  scene.spacing = 0.05;
  scene.bounds_min = {-0.2, -0.2, -0.2};
  scene.bounds_max = {0.2, 0.2, 0.2};
  BodyDescription box;
  box.name = "box";
  box.kind = BodyKind::fixed;
  box.color = {1, 0, 0};
  add_box(box, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, true, true);
  scene.bodies = {box};
  return scene;
}

Reading cut(int axis, double share, bool flipped = false) {
  Reading reading;
  reading.clip = {true, axis, share, flipped};
  return reading;
}

TEST(Cut, TakesTheUpperHalfOfASolid) {
  Stage stage(small_stage());
  set_scene(stage, red_box());
  stage.go_home();
  const osg::Vec3d upper(0.099, -0.1, 0.08), lower(0.0, -0.1, -0.05);
  const Picture whole = shoot(stage);
  stage.scene().set_reading(cut(2, 0.5));
  const Picture open = shoot(stage);
  EXPECT_TRUE(reddish(at(whole, stage.project(upper))));
  EXPECT_TRUE(reddish(at(whole, stage.project(lower))));
  EXPECT_TRUE(reddish(at(open, stage.project(lower))));
  const int before = find(whole, reddish).pixels, after = find(open, reddish).pixels;
  EXPECT_LT(after, 0.85 * before);
  EXPECT_GT(after, 0.3 * before) << "one sees the far walls from inside";
  stage.scene().set_reading(cut(2, 0.5, true));
  EXPECT_FALSE(reddish(at(shoot(stage), stage.project(lower))) && find(shoot(stage), reddish).pixels == after)
      << "the other side is another picture";
  stage.scene().set_reading({});
  EXPECT_EQ(differing(whole, shoot(stage)), 0);
}

TEST(Cut, TakesParticlesOfMediaAndBeads) {
  SyntheticScene s = synthetic_scene();
  make_look(s.scene.bodies[0], "custard");  // opaque, in its blue
  for (const bool beads : {true, false}) {
    Stage stage(small_stage());
    set_scene(stage, s.scene);
    stage.scene().set_beads(beads);
    stage.scene().set_frame(s.frame);
    stage.go_home();
    const auto blue = [](Pixel p) { return p.b > 70 && p.b > p.r + 40; };
    const int whole = find(shoot(stage), blue).pixels;
    ASSERT_GT(whole, 1000);
    stage.scene().set_reading(cut(0, 0.5));
    stage.scene().set_frame(s.frame);
    const int half = find(shoot(stage), blue).pixels;
    EXPECT_GT(half, 0.2 * whole) << beads;
    EXPECT_LT(half, 0.75 * whole) << beads;
    stage.scene().set_reading(cut(0, 0));
    stage.scene().set_frame(s.frame);
    EXPECT_LT(find(shoot(stage), blue).pixels, 0.02 * whole) << beads;
  }
}

}  // namespace
}  // namespace palp::test::reading_image_test
