// The hand in pictures of scenes that are made from formulas.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/stage.h"

namespace palp::test {
namespace {

// The paddle is held by device 0, at rest where the simulation has it.
SyntheticScene held_paddle() {
  SyntheticScene s = synthetic_scene();
  s.scene.proxies = {{0, 2, s.poses.pose[0]}};
  s.poses.sim_time = s.proxy.sim_time;
  s.proxy.flags = kEngaged | kHealthy;
  s.proxy.device_pose = s.proxy.proxy_pose;
  s.proxy.wrench = {};
  return s;
}

// Stands before the scene as one looks from home.
void add_wall(SyntheticScene& s, std::array<double, 3> low, std::array<double, 3> high) {
  BodyDescription wall;
  wall.kind = BodyKind::rigid;
  wall.color = {0.1f, 0.1f, 0.1f};
  add_box(wall, low, high, true, true);
  s.poses.body.push_back(static_cast<std::uint32_t>(s.scene.bodies.size()));
  s.scene.bodies.push_back(wall);
  s.poses.pose.push_back({});
}

void set(Stage& stage, const SyntheticScene& s) {
  stage.hud().set_visible(false);
  set_scene(stage, s.scene);
  stage.scene().set_poses(s.poses);
  stage.scene().set_frame(s.frame);
  stage.scene().set_proxy(s.proxy);
  stage.scene().set_values(s.proxy.device, s.proxy.wrench);
  stage.go_home();
}

Picture picture_of(const SyntheticScene& s) {
  Stage stage(small_stage(640, 480));
  set(stage, s);
  return shoot(stage);
}

// Where two pictures differ.
Spot difference(const Picture& a, const Picture& b) {
  Spot spot;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const Pixel p = at(a, x, y), q = at(b, x, y);
      if (std::abs(p.r - q.r) + std::abs(p.g - q.g) + std::abs(p.b - q.b) < 12) continue;
      ++spot.pixels;
      spot.middle += osg::Vec2d(x + 0.5, y + 0.5);
    }
  }
  if (spot.pixels > 0) spot.middle /= spot.pixels;
  return spot;
}

TEST(HandView, TheToolIsShownWhereTheHandWantsIt) {
  SyntheticScene s = held_paddle();
  const Picture rest = picture_of(s);
  s.proxy.device_pose.position[0] -= 0.09;
  Stage stage(small_stage(640, 480));
  set(stage, s);
  const Spot seen = difference(rest, shoot(stage));
  EXPECT_TRUE(stage.scene().hand(0).wish_shown());
  ASSERT_GT(seen.pixels, 800);
  // the wished paddle, from the top of its handle to the water, and the line from it to the tool
  const auto& p = s.proxy.device_pose.position;
  const osg::Vec2d middle = stage.project({p[0] + 0.01, p[1], p[2]});
  EXPECT_LT((seen.middle - middle).length(), 30) << seen.middle.x() << ' ' << seen.middle.y();
}

// The blade stands in opaque liquid: its marks glimmer through.
TEST(HandView, WhereMediaTouchTheToolIsMarked) {
  SyntheticScene s = held_paddle();
  make_look(s.scene.bodies[0], "custard");
  s.scene.bodies[0].color = {0.2f, 0.5f, 0.9f};
  s.frame.field = ScalarField::pressure;
  Stage stage(small_stage(640, 480));
  set(stage, s);
  const Picture plain = shoot(stage);
  EXPECT_FALSE(stage.scene().touch());

  stage.scene().set_touch_marked(true);
  stage.scene().set_frame(s.frame);
  const Picture marked = shoot(stage);
  const Spot seen = difference(plain, marked);
  ASSERT_GT(seen.pixels, 300);
  // 5 cm of the blade are in the liquid, and its lower edge
  const auto& p = s.poses.pose[0].position;
  EXPECT_LT((seen.middle - stage.project({p[0], p[1], p[2] - 0.075})).length(), 30);
  ASSERT_TRUE(stage.scene().touch());
  EXPECT_GT(stage.scene().touch()->area, 0.03 * 0.056);
  EXPECT_LT(stage.scene().touch()->area, 2 * 0.06 * (0.056 + 0.01) + 0.002);
  EXPECT_FALSE(stage.scene().touch()->pressure) << "colours show no pressure";

  stage.scene().set_color(ScalarField::pressure);
  stage.scene().set_frame(s.frame);
  EXPECT_GT(differing(marked, shoot(stage)), 300);
  EXPECT_GT(stage.scene().touch()->pressure.value(), 0);

  stage.scene().set_color(ScalarField::none);
  stage.scene().set_touch_marked(false);
  stage.scene().set_frame(s.frame);
  EXPECT_EQ(differing(plain, shoot(stage)), 0);
}

TEST(HandView, MarksDoNotShineThroughSolids) {
  SyntheticScene s = held_paddle();
  make_look(s.scene.bodies[0], "custard");
  add_wall(s, {-0.4, -0.14, -0.01}, {0.4, -0.13, 0.5});
  Stage stage(small_stage(640, 480));
  set(stage, s);
  const Picture plain = shoot(stage);
  stage.scene().set_touch_marked(true);
  stage.scene().set_frame(s.frame);
  ASSERT_GT(stage.scene().touch().value().area, 0);
  EXPECT_EQ(difference(plain, shoot(stage)).pixels, 0);
}

TEST(HandView, TheEndOfTheArmsReachIsShownWhereTheHandComesNearIt) {
  const SyntheticScene s = held_paddle();
  Stage stage(small_stage(640, 480));
  set(stage, s);
  const Picture plain = shoot(stage);
  const auto& p = s.proxy.device_pose.position;
  HandReach reach{{p[0], p[1], p[2]}, {0.3, 0.3, 0.3}};
  stage.scene().set_reaches({{0, reach}});
  EXPECT_EQ(differing(plain, shoot(stage)), 0) << "the hand is far from all sides";
  reach.center.x() += 0.3;
  stage.scene().set_reaches({{0, reach}});
  const int one_side = differing(plain, shoot(stage));
  EXPECT_GT(one_side, 200);
  reach.clutched = true;
  stage.scene().set_reaches({{0, reach}});
  EXPECT_GT(differing(plain, shoot(stage)), one_side);
  stage.scene().set_reaches({});
  EXPECT_EQ(differing(plain, shoot(stage)), 0);
}

TEST(HandView, NoWishIsShownWhereThereIsNone) {
  const Picture rest = picture_of(held_paddle());
  SyntheticScene near = held_paddle(), loose = held_paddle(), senseless = held_paddle();
  near.proxy.device_pose.position[0] += 0.001;
  loose.proxy.device_pose.position[0] += 0.1;
  loose.proxy.flags = kHealthy;
  senseless.proxy.device_pose.position[0] = std::nan("");
  for (const SyntheticScene& s : {near, loose, senseless}) EXPECT_EQ(differing(rest, picture_of(s)), 0);
}

TEST(HandView, ATorqueBendsAroundTheHandle) {
  SyntheticScene s = held_paddle();
  const Picture rest = picture_of(s);
  s.proxy.wrench.torque = {0, 0, 0.4};
  Stage stage(small_stage(640, 480));
  set(stage, s);
  stage.scene().set_values_shown(false);
  const Spot seen = find(shoot(stage), orange);
  ASSERT_GT(seen.pixels, 150);
  const auto& p = s.proxy.proxy_pose.position;
  EXPECT_LT((seen.middle - stage.project({p[0], p[1], p[2]})).length(), 40);
  s.proxy.wrench.torque[1] = std::nan("");
  EXPECT_EQ(differing(rest, picture_of(s)), 0);
}

// Returns what the values add to the stage's picture, and hides them.
Spot values_in(Stage& stage) {
  const Picture with = shoot(stage);
  stage.scene().set_values_shown(false);
  return difference(with, shoot(stage));
}

TEST(HandView, ForcesHaveTheirValuesBesideThem) {
  SyntheticScene s = held_paddle();
  s.proxy.wrench.force = {1.9, 0, 0.4};
  Stage stage(small_stage(640, 480));
  set(stage, s);
  const Spot words = values_in(stage);
  EXPECT_GT(words.pixels, 60);
  const osg::Vec3d force(1.9, 0, 0.4);
  const auto& p = s.proxy.proxy_pose.position;
  const osg::Vec3d tip =
      osg::Vec3d(p[0], p[1], p[2]) + force * (stage.scene().arrow_length() / stage.scene().arrow_force());
  const osg::Vec2d gap = words.middle - stage.project(tip);
  EXPECT_GT(gap.x(), 0);
  EXPECT_LT(gap.length(), 70) << "pixels";
}

TEST(HandView, ValuesAreNotWrittenOverEachOther) {
  int pixels[3];
  for (int k = 0; k < 3; ++k) {
    SyntheticScene s = held_paddle();
    // the arrow's tip is where the value of the torque stands
    if (k != 0) s.proxy.wrench.force = {0, 0, 0.11};
    if (k != 1) s.proxy.wrench.torque = {0, 0, 0.4};
    Stage stage(small_stage(640, 480));
    set(stage, s);
    pixels[k] = values_in(stage).pixels;
  }
  EXPECT_GT(pixels[0], 60);
  EXPECT_GT(pixels[1], 60);
  EXPECT_GT(pixels[2], 0.9 * (pixels[0] + pixels[1]));
}

TEST(HandView, NothingHidesAValue) {
  int pixels[2];
  for (const bool behind : {false, true}) {
    SyntheticScene s = held_paddle();
    s.proxy.wrench.force = {1.9, 0, 0.4};
    if (behind) add_wall(s, {-0.2, -0.14, -0.01}, {0.3, -0.13, 0.25});
    Stage stage(small_stage(640, 480));
    set(stage, s);
    pixels[behind] = values_in(stage).pixels;
  }
  EXPECT_GT(pixels[1], 0.8 * pixels[0]);
}

TEST(HandView, HandsHaveColorsOfTheirOwn) {
  SyntheticScene s = held_paddle();
  s.proxy.wrench.force = {2, 0, 0};
  Stage stage(small_stage(640, 480));
  set(stage, s);
  const Picture first = shoot(stage);
  stage.scene().hide_proxy(0);
  s.proxy.device = 1;
  stage.scene().set_proxy(s.proxy);
  const Picture second = shoot(stage);
  const auto& p = s.proxy.proxy_pose.position;
  const osg::Vec2d middle = stage.project({p[0] + 0.5 * stage.scene().arrow_length(), p[1], p[2]});
  EXPECT_GT(at(first, middle).r, at(first, middle).b + 60);
  EXPECT_GT(at(second, middle).b, at(second, middle).r + 60);
}

}  // namespace
}  // namespace palp::test
