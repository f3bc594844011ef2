// The timeline, captions and scripted camera of a recording, in pictures.
#include "viewer/replay_overlay.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"

namespace palp::test {
namespace {

// Pixels whose colour is that of the part of the timeline that has passed.
int amber_pixels(const Picture& picture) {
  int count = 0;
  for (std::size_t i = 0; i + 2 < picture.rgb.size(); i += 3)
    count += picture.rgb[i] > 200 && picture.rgb[i + 1] > 120 && picture.rgb[i + 1] < 220 && picture.rgb[i + 2] < 110;
  return count;
}

TEST(ReplayOverlayPicture, TheTimelineGrowsAndCaptionsShow) {
  Stage stage(small_stage());
  ReplayOverlay overlay;
  stage.add_overlay(overlay.camera());
  overlay.set_size(stage.width(), stage.height());
  const Picture none = shoot(stage);
  overlay.set_timeline_shown(true);
  overlay.set_timeline(0, 8, 2, 1, false);
  const int quarter = amber_pixels(shoot(stage));
  overlay.set_timeline(0, 8, 8, 1, false);
  // the bar is 0.7 of 320 pixels wide and 3 high
  EXPECT_NEAR(amber_pixels(shoot(stage)), 0.7 * 320 * 3, 30);
  EXPECT_NEAR(quarter, 0.25 * 0.7 * 320 * 3, 30);
  overlay.set_timeline_shown(false);
  EXPECT_EQ(differing(none, shoot(stage)), 0);
  overlay.set_caption("Batter is poured", 1);
  EXPECT_GT(differing(none, shoot(stage)), 1000);
  overlay.set_caption("Batter is poured", 0);
  EXPECT_EQ(differing(none, shoot(stage)), 0);
}

// The camera of a script stays where it was put, with its field of view.
TEST(ReplayOverlayPicture, TheCameraOfAScriptHolds) {
  Stage stage(small_stage());
  const SyntheticScene s = synthetic_scene();
  set_scene(stage, s.scene);
  stage.scene().set_frame(s.frame);
  stage.go_home();
  stage.set_camera({{0.3, -0.4, 0.3}, {0, 0, 0}}, 40);
  shoot(stage);
  const osg::Vec2d middle = stage.project({0, 0, 0});
  EXPECT_NEAR(middle.x(), 160, 0.01);
  EXPECT_NEAR(middle.y(), 120, 0.01);
  // a point at the edge of 40 degrees, seen along the view
  const osg::Vec3d view = osg::Vec3d(-0.3, 0.4, -0.3);
  osg::Vec3d right = view ^ osg::Vec3d(0, 0, 1);
  right.normalize();
  osg::Vec3d up = right ^ view;
  up.normalize();
  EXPECT_NEAR(stage.project(up * (view.length() * std::tan(osg::DegreesToRadians(20.0)))).y(), 240, 0.01);
}

}  // namespace
}  // namespace palp::test
