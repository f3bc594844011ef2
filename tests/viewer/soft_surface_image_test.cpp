// Pictures of soft bodies by the surface that their particles carry along.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/stage.h"

namespace palp::test::soft_surface_image_test {
namespace {

constexpr std::array<int, 3> kSides{16, 8, 6};

// A block of jelly on its own, in cells from the origin.
SyntheticScene soft_block() {
  SyntheticScene s = synthetic_scene();
  s.poses = {};
  s.scene.bodies.resize(1);
  BodyDescription& body = s.scene.bodies[0];
  body.kind = BodyKind::elastic;
  body.color = {0.95f, 0.95f, 0.95f};
  make_look(body, "batter");
  add_box(body, {0, 0, 0}, {kSides[0] * kSpacing, kSides[1] * kSpacing, kSides[2] * kSpacing}, true, true);
  for (int k = 0; k < kSides[2]; ++k)
    for (int j = 0; j < kSides[1]; ++j)
      for (int i = 0; i < kSides[0]; ++i)
        for (const int n : {i, j, k}) body.rest.push_back(static_cast<float>(kSpacing * (n + 0.5)));
  s.scene.particle_count = body.count = static_cast<std::uint32_t>(body.rest.size() / 3);
  s.frame.positions = body.rest;
  s.frame.field = ScalarField::none;
  s.frame.scalars.clear();
  return s;
}

void set(Stage& stage, const SyntheticScene& s) {
  stage.hud().set_visible(false);
  set_scene(stage, s.scene);
  stage.scene().set_frame(s.frame);
  stage.go_home();
}

// Returns whether something bright is seen there.
bool covered(const Stage& stage, const Picture& picture, const osg::Vec3d& place) {
  return at(picture, stage.project(place)).g > 90;
}

// The pixels that a block from the origin covers, were its corners sharp: the area of their hull in the picture.
double pixels_of_hull(const Stage& stage) {
  std::vector<osg::Vec2d> corners;
  for (int c = 0; c < 8; ++c)
    corners.push_back(stage.project(
        {c & 1 ? kSides[0] * kSpacing : 0, c & 2 ? kSides[1] * kSpacing : 0, c & 4 ? kSides[2] * kSpacing : 0}));
  const auto turn = [](const osg::Vec2d& a, const osg::Vec2d& b, const osg::Vec2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  double area = 0;  // of the triangles between the first corner and the edges that have all others on one side
  for (const osg::Vec2d& a : corners)
    for (const osg::Vec2d& b : corners)
      if (std::ranges::all_of(corners, [&](const osg::Vec2d& c) { return turn(a, b, c) > -1e-6; }) && a != b)
        area += 0.5 * turn(corners[0], a, b);
  return area;
}

TEST(SoftSurfaceImage, ABlockHasTheCornersOfItsSolid) {
  const SyntheticScene s = soft_block();
  Stage stage(small_stage(640, 480));
  set(stage, s);
  const auto covered_pixels = [&] { return find(shoot(stage), [](Pixel p) { return p.g > 75; }).pixels; };
  const int as_surface = covered_pixels();
  stage.scene().set_beads(true);
  stage.scene().set_frame(s.frame);
  const double hull = pixels_of_hull(stage);
  EXPECT_NEAR(as_surface, hull, 0.005 * hull);
  EXPECT_LT(covered_pixels(), 0.98 * hull) << "beads are round";
}

TEST(SoftSurfaceImage, FollowsParticlesAndGivesWayWhereTheyAreTornApart) {
  SyntheticScene s = soft_block();
  Stage stage(small_stage(640, 480));
  set(stage, s);
  const osg::Vec3d cut(8 * kSpacing, 4 * kSpacing, kSides[2] * kSpacing);
  EXPECT_TRUE(covered(stage, shoot(stage), cut));
  std::vector<float>& x = s.frame.positions;
  for (std::size_t i = 0; i < x.size(); i += 3) x[i] += static_cast<float>(x[i] > cut.x() ? 4 * kSpacing : 0);
  stage.scene().set_frame(s.frame);
  const Picture torn = shoot(stage);
  const osg::Vec3d along(kSpacing, 0, 0);
  EXPECT_FALSE(covered(stage, torn, cut + along * 2)) << "no skin across the gap";
  for (const double at : {-6.0, -4.0, -3.0, -2.0, -1.0, 5.0, 6.0, 7.0, 8.0, 10.0})
    EXPECT_TRUE(covered(stage, torn, cut + along * at)) << "a hole at " << at;
  // whole again, the picture is the one of before
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = s.scene.bodies[0].rest[i];
  stage.scene().set_frame(s.frame);
  EXPECT_TRUE(covered(stage, shoot(stage), cut));
}

TEST(SoftSurfaceImage, ShowsParticlesWhereNumbersAreShownOrTheSceneIsCutOpen) {
  SyntheticScene s = soft_block();
  Stage stage(small_stage());
  set(stage, s);
  const Picture as_surface = shoot(stage);
  s.frame.field = ScalarField::speed;
  s.frame.scalars.assign(s.scene.particle_count, 0.2f);
  stage.scene().set_color(ScalarField::speed);
  stage.scene().set_frame(s.frame);
  EXPECT_GT(differing(as_surface, shoot(stage)), 500);
  EXPECT_GT(stage.scene().cloud().seen(), 0u);
  stage.scene().set_color(ScalarField::none);
  stage.scene().set_frame(s.frame);
  EXPECT_EQ(stage.scene().cloud().seen(), 0u);
  EXPECT_EQ(differing(as_surface, shoot(stage)), 0);
  Reading reading;
  reading.clip.on = true;
  stage.scene().set_reading(reading);
  stage.scene().set_frame(s.frame);
  EXPECT_GT(stage.scene().cloud().seen(), 0u);
}

}  // namespace
}  // namespace palp::test::soft_surface_image_test
