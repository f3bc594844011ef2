// Pictures of scenes that are made from formulas: what must be seen is computed here, not compared with a stored
// picture.
#include <gtest/gtest.h>

#include <set>

#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/home_view.h"
#include "viewer/stage.h"

namespace palp::test::image_test {
namespace {

constexpr double kBigSpacing = 0.05;
constexpr double kRadius = 0.58 * kBigSpacing;  // as drawn

BodyDescription particles(std::array<float, 3> color, std::uint32_t first, std::uint32_t count) {
  BodyDescription body;
  body.name = "dots";
  body.color = color;
  body.density = 1000;
  body.first = first;
  body.count = count;
  return body;
}

// Red, green and blue, one particle each.
SceneDescription three_dots() {
  SceneDescription scene;
  scene.spacing = kBigSpacing;
  scene.particle_count = 3;
  scene.bounds_min = {-0.2, -0.2, -0.2};
  scene.bounds_max = {0.2, 0.2, 0.2};
  scene.bodies = {particles({1, 0, 0}, 0, 1), particles({0, 1, 0}, 1, 1), particles({0, 0, 1}, 2, 1)};
  return scene;
}

ParticleFrame frame_of(std::vector<float> positions) {
  ParticleFrame frame;
  frame.positions = std::move(positions);
  return frame;
}

void set(Stage& stage, const SyntheticScene& s, ScalarField field) {
  set_scene(stage, s.scene);
  stage.scene().set_color(field);
  stage.scene().set_poses(s.poses);
  stage.scene().set_frame(s.frame);
  stage.scene().set_proxy(s.proxy);
  stage.go_home();
}

osg::Vec3d eye_of(Stage& stage) {
  osg::Vec3d eye, center, up;
  stage.viewer().getCamera()->getViewMatrixAsLookAt(eye, center, up);
  return eye;
}

TEST(Image, EveryParticleIsWhereItMustBeInItsBodysColor) {
  Stage stage(small_stage());
  stage.scene().set_beads(true);
  stage.hud().set_visible(false);
  set_scene(stage, three_dots());
  stage.go_home();
  const osg::Vec3d places[] = {{-0.1, 0.05, 0.02}, {0.09, -0.04, -0.06}, {0.02, 0.03, 0.12}};
  std::vector<float> positions;
  for (const osg::Vec3d& p : places) {
    for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>(p[k]));
  }
  stage.scene().set_frame(frame_of(positions));
  const Picture picture = shoot(stage);
  bool (*const looks[])(Pixel) = {reddish, greenish, bluish};
  for (int i = 0; i < 3; ++i) {
    const osg::Vec2d expected = stage.project(places[i]);
    const Spot spot = find(picture, looks[i]);
    ASSERT_GT(spot.pixels, 50) << "particle " << i;
    // the lit part is what is counted: its middle may lie a little to the light
    EXPECT_LT((spot.middle - expected).length(), 0.25 * spot.radius + 1) << "particle " << i;
    const double distance = (eye_of(stage) - places[i]).length();
    const double pixels = kRadius / distance / std::tan(osg::DegreesToRadians(kFieldOfView) / 2) * picture.height / 2;
    EXPECT_NEAR(spot.radius, pixels, 0.12 * pixels + 1) << "particle " << i;
    EXPECT_TRUE(looks[i](at(picture, expected)));
  }
}

TEST(Image, ParticlesHaveTheDepthOfSpheres) {
  // A wall stands between a particle's centre and the eye, 0.3 radii before the centre: the middle of the sphere comes
  // through the wall and its rim does not.
  Stage stage(small_stage());
  stage.scene().set_beads(true);
  stage.hud().set_visible(false);
  SceneDescription scene = three_dots();
  BodyDescription wall;
  wall.kind = BodyKind::fixed;
  wall.color = {1, 0, 0};
  set_scene(stage, scene);
  stage.go_home();
  shoot(stage);  // puts the camera there
  const osg::Vec3d eye = eye_of(stage);
  osg::Vec3d ignored_eye, ahead, up_of_view;
  stage.viewer().getCamera()->getViewMatrixAsLookAt(ignored_eye, ahead, up_of_view);
  const osg::Vec3d to_eye = eye - ahead;  // of length 1
  const osg::Vec3d center = eye - to_eye * (eye - stage.scene().content().center()).length();
  osg::Vec3d right = osg::Vec3d(0, 0, 1) ^ to_eye;
  right.normalize();
  const osg::Vec3d up = to_eye ^ right;
  std::array<std::array<double, 3>, 4> corners;
  const double sides[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (std::size_t i = 0; i < 4; ++i) {
    const osg::Vec3d c = center + to_eye * (0.3 * kRadius) + right * (0.1 * sides[i][0]) + up * (0.1 * sides[i][1]);
    corners[i] = {c.x(), c.y(), c.z()};
  }
  add_quad(wall, corners);
  scene.bodies.push_back(wall);
  set_scene(stage, scene);
  std::vector<float> positions(9, 5.0f);  // two of them out of sight
  for (int k = 0; k < 3; ++k) positions[6 + static_cast<std::size_t>(k)] = static_cast<float>(center[k]);
  stage.scene().set_frame(frame_of(positions));
  const Picture picture = shoot(stage);
  EXPECT_TRUE(bluish(at(picture, stage.project(center))));
  EXPECT_TRUE(bluish(at(picture, stage.project(center + right * (0.7 * kRadius)))));
  EXPECT_FALSE(bluish(at(picture, stage.project(center + right * (0.985 * kRadius)))));
  EXPECT_FALSE(bluish(at(picture, stage.project(center - up * (0.985 * kRadius)))));
}

TEST(Image, FluidIsSeenThroughTheNearWallAndTheFarWallIsThere) {
  Stage stage(small_stage());
  stage.hud().set_visible(false);
  SyntheticScene s = synthetic_scene();
  s.scene.bodies[0].color = {0, 1, 0};
  make_look(s.scene.bodies[0], "water");
  set(stage, s, ScalarField::none);
  const Picture picture = shoot(stage);
  // half way up the fluid, on the outer side of the near wall
  const Pixel near = at(picture, stage.project({0.02, -kHalfY - kWall, 0.025}));
  EXPECT_TRUE(near.g > near.r + 40 && near.g > near.b + 40) << near.r << ' ' << near.g << ' ' << near.b;
  // above the fluid, on the inner side of the far wall: grey and bright against the background
  const Pixel far = at(picture, stage.project({-0.05, kHalfY, 0.070}));
  EXPECT_GT(far.g, 70);
  EXPECT_LT(std::abs(far.g - far.r), 25);
}

TEST(Image, ColorModesDiffer) {
  std::vector<Picture> seen;
  for (const ScalarField field : {ScalarField::none, ScalarField::speed, ScalarField::density}) {
    Stage stage(small_stage());
    stage.hud().set_visible(false);
    set(stage, synthetic_scene(0.4, field == ScalarField::none ? ScalarField::speed : field), field);
    EXPECT_EQ(stage.scene().cloud().shown_field(), field);
    seen.push_back(shoot(stage));
  }
  EXPECT_GT(differing(seen[0], seen[1]), 1000);
  EXPECT_GT(differing(seen[0], seen[2]), 1000);
  EXPECT_GT(differing(seen[1], seen[2]), 1000);
}

TEST(Image, AFieldThatTheFrameLacksIsShownByBody) {
  Stage stage(small_stage());
  set(stage, synthetic_scene(0.4, ScalarField::speed), ScalarField::density);
  EXPECT_EQ(stage.scene().cloud().shown_field(), ScalarField::none);
}

// Walls and tools have a density for the solver's sake only: they must not set the range, and keep their colour.
TEST(Image, WallsDoNotStretchTheRangeOfTheFluidsDensity) {
  Stage stage(small_stage());
  stage.hud().set_visible(false);
  SceneDescription scene = three_dots();
  scene.bodies[2].kind = BodyKind::fixed;
  set_scene(stage, scene);
  stage.scene().set_color(ScalarField::density);
  stage.go_home();
  ParticleFrame frame = frame_of({-0.1f, 0, 0, 0, 0, 0, 0.1f, 0, 0});
  frame.field = ScalarField::density;
  frame.scalars = {998, 1003, 7800};
  stage.scene().set_frame(frame);
  EXPECT_EQ(stage.scene().cloud().range(), (ValueRange{995, 1005}));
  const Picture picture = shoot(stage);
  EXPECT_TRUE(bluish(at(picture, stage.project({0.1, 0, 0})))) << "the colour of its body";
  EXPECT_FALSE(greenish(at(picture, stage.project({0, 0, 0})))) << "a colour of the map";
}

TEST(Image, FastParticlesAreBrighterThanSlowOnes) {
  Stage stage(small_stage());
  stage.scene().set_beads(true);
  stage.hud().set_visible(false);
  SceneDescription scene = three_dots();
  set_scene(stage, scene);
  stage.scene().set_color(ScalarField::speed);
  stage.go_home();
  ParticleFrame frame = frame_of({-0.1f, 0, 0, 0, 0, 0, 0.1f, 0, 0});
  frame.field = ScalarField::speed;
  frame.scalars = {0, 0.5f, 1};
  stage.scene().set_frame(frame);
  const Picture picture = shoot(stage);
  const auto sum = [&](float x) {
    const Pixel p = at(picture, stage.project({x, 0, 0}));
    return p.r + p.g + p.b;
  };
  EXPECT_LT(sum(-0.1f) + 60, sum(0));
  EXPECT_LT(sum(0) + 60, sum(0.1f));
}

TEST(Image, TheSameSceneGivesTheSameBytes) {
  Picture pictures[2];
  for (Picture& picture : pictures) {
    Stage stage(small_stage());
    set(stage, synthetic_scene(), ScalarField::speed);
    HudData data;
    data.connected = true;
    data.force = 2;
    stage.hud().set_data(data);
    shoot(stage);
    picture = shoot(stage);
  }
  ASSERT_FALSE(pictures[0].rgb.empty());
  EXPECT_EQ(pictures[0].rgb, pictures[1].rgb);
  EXPECT_GT((std::set<std::uint8_t>(pictures[0].rgb.begin(), pictures[0].rgb.end()).size()), 100u);
}

TEST(Image, TheArrowStartsAtTheHandleAndPointsAlongTheForce) {
  const osg::Vec3d forces[] = {{3, 0, 0}, {-3, 0, 0}, {0, 0, 3}, {0, 2, -2}, {1, 2, 3}};
  for (const osg::Vec3d& force : forces) {
    Stage stage(small_stage());
    stage.hud().set_visible(false);
    set_scene(stage, three_dots());
    stage.go_home();
    ProxySample proxy;
    proxy.proxy_pose.position = {0.03, -0.02, 0.05};
    proxy.wrench.force = {force.x(), force.y(), force.z()};
    stage.scene().set_proxy(proxy);
    const Spot arrow = find(shoot(stage), orange);
    ASSERT_GT(arrow.pixels, 60);
    const osg::Vec3d handle(0.03, -0.02, 0.05);
    const double length = stage.scene().arrow_length() * force.length() / stage.scene().arrow_force();
    const osg::Vec2d tail = stage.project(handle), tip = stage.project(handle + force / force.length() * length);
    const osg::Vec2d along = tip - tail, seen = arrow.middle - tail;
    // the middle of its area lies past half of its length, as the head is wide, and on its line
    const double share = (seen * along) / along.length2();
    const double aside = std::abs(seen.x() * along.y() - seen.y() * along.x()) / along.length();
    EXPECT_GT(share, 0.45);
    EXPECT_LT(share, 0.85);
    EXPECT_LT(aside, 3) << "pixels";
  }
}

TEST(Image, NoForceNoArrow) {
  Stage stage(small_stage());
  stage.hud().set_visible(false);
  set_scene(stage, three_dots());
  const Picture before = shoot(stage);
  ProxySample proxy;
  stage.scene().set_proxy(proxy);
  proxy.device = kMaxDevices;
  proxy.wrench.force = {9, 9, 9};
  stage.scene().set_proxy(proxy);
  EXPECT_EQ(before.rgb, shoot(stage).rgb);
}

TEST(Image, FiguresAreReadableAndChange) {
  Stage stage(small_stage(800, 600));
  stage.hud().set_detail(HudDetail::full);
  set_scene(stage, three_dots());
  const auto bright = [](Pixel p) { return p.r > 140 && p.g > 140 && p.b > 140; };
  HudData data;
  data.connected = true;
  data.frame_age = 0.01;
  shoot(stage);
  stage.hud().set_data(data);
  const Picture shown = shoot(stage);
  EXPECT_GT(find(shown, bright).pixels, 100);
  data.force = 3.21;
  stage.hud().set_data(data);
  const int changed = differing(shown, shoot(stage));
  EXPECT_GT(changed, 20);
  EXPECT_LT(changed, 3000);
  stage.hud().set_visible(false);
  EXPECT_EQ(find(shoot(stage), bright).pixels, 0);
}

TEST(Image, ParticleCountsMayChangeFromFrameToFrame) {
  Stage stage(small_stage());
  stage.hud().set_visible(false);
  SyntheticScene s = synthetic_scene();
  set(stage, s, ScalarField::speed);
  const Picture full = shoot(stage);
  for (const std::size_t count : {10u, 0u, 2000u, 1u, 3000u, 0u}) {
    ParticleFrame frame = s.frame;
    frame.positions.resize(3 * count);
    frame.scalars.resize(count);
    stage.scene().set_frame(frame);
    EXPECT_EQ(stage.scene().cloud().drawn(), count);
    EXPECT_GT(differing(full, shoot(stage)), 100);
  }
  ParticleFrame more = s.frame;  // particles that no body claims
  more.positions.resize(3 * s.frame.scalars.size() + 30, 0.0f);
  more.scalars.resize(s.frame.scalars.size() + 10, 0.0f);
  stage.scene().set_frame(more);
  EXPECT_EQ(stage.scene().cloud().drawn(), s.frame.scalars.size());
  stage.scene().set_frame(s.frame);
  EXPECT_EQ(full.rgb, shoot(stage).rgb);
}

TEST(Image, AnotherSceneReplacesAllOfTheFirst) {
  Stage fresh(small_stage()), used(small_stage());
  set(used, synthetic_scene(), ScalarField::speed);
  shoot(used);
  Picture pictures[2];
  for (int i = 0; i < 2; ++i) {
    Stage& stage = i == 0 ? fresh : used;
    stage.hud().set_visible(false);
    set_scene(stage, three_dots());
    stage.scene().set_color(ScalarField::none);
    stage.scene().set_frame(frame_of({-0.1f, 0, 0, 0, 0, 0, 0.1f, 0, 0}));
    stage.go_home();
    pictures[i] = shoot(stage);
  }
  EXPECT_EQ(pictures[0].rgb, pictures[1].rgb);
}

TEST(Image, SenselessNumbersDrawNothingAndDoNoHarm) {
  Stage stage(small_stage());
  stage.hud().set_visible(false);
  SyntheticScene s = synthetic_scene();
  const float nan = std::nanf("");
  s.scene.bounds_max = {std::nan(""), 0, 0};
  s.scene.bodies[1].vertices[0] = nan;
  s.scene.bodies[1].triangles.push_back(4'000'000'000u);
  s.scene.bodies[0].count = 4'000'000'000u;
  s.frame.positions[7] = nan;
  s.frame.positions[9] = 1e30f;
  s.frame.scalars[3] = nan;
  s.poses.body.push_back(99);
  s.poses.pose.push_back({});
  s.poses.body.push_back(1);
  s.poses.pose.push_back({{std::nan(""), 0, 0}, {0, 0, 0, 1}});
  s.proxy.wrench.force = {std::nan(""), 0, 0};
  set(stage, s, ScalarField::speed);
  EXPECT_GT(differing(shoot(stage), Picture{320, 240, std::vector<std::uint8_t>(3 * 320 * 240)}), 1000);
}

TEST(Image, HomeShowsAllOfTheScene) {
  Stage stage(small_stage());
  set(stage, synthetic_scene(), ScalarField::speed);
  shoot(stage);
  osg::BoundingBoxd seen;
  for (const osg::Vec3d& point : stage.scene().outline()) {
    const osg::Vec2d p = stage.project(point);
    EXPECT_TRUE(p.x() > 0 && p.x() < 320 && p.y() > 0 && p.y() < 240) << p.x() << ' ' << p.y();
    seen.expandBy(osg::Vec3d(p.x(), p.y(), 0));
  }
  // as near as it can be: the width or the height is used
  EXPECT_GT(std::max((seen.xMax() - seen.xMin()) / 320, (seen.yMax() - seen.yMin()) / 240), 0.80);
}

TEST(Image, TheCameraStepsBackForAToolThatLeavesThePicture) {
  Stage stage(small_stage());
  SyntheticScene s = synthetic_scene();
  s.scene.proxies = {{0, 2, s.poses.pose[0]}};
  s.scene.bounds_max[2] = 0.6;
  set(stage, s, ScalarField::none);
  shoot(stage);
  const double before = (eye_of(stage) - stage.scene().content().center()).length();
  const auto show_at = [&](double z) {
    s.poses.pose[0].position[2] = z;
    stage.scene().set_poses(s.poses);
    shoot(stage);
    shoot(stage);
    return stage.project({s.poses.pose[0].position[0], s.poses.pose[0].position[1], z + 0.06});
  };
  const osg::Vec2d top = show_at(0.4);
  EXPECT_TRUE(top.y() < 240 && top.y() > 120) << top.y();
  EXPECT_GT((eye_of(stage) - stage.scene().content().center()).length(), 1.1 * before);
  const osg::Vec3d eye = eye_of(stage);
  show_at(0.105);
  EXPECT_EQ(eye_of(stage), eye) << "it does not step forth again";
  show_at(30);
  EXPECT_EQ(eye_of(stage), eye) << "a tool out of the domain is a fault";
}

}  // namespace
}  // namespace palp::test::image_test
