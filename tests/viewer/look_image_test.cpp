// Looks in pictures: what optics says of them must be seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/stage.h"

namespace palp::test::look_image_test {
namespace {

BodyDescription box(std::array<float, 3> color, const Look& look, std::array<double, 3> low,
                    std::array<double, 3> high) {
  BodyDescription body;
  body.name = "box";
  body.kind = BodyKind::fixed;
  body.color = color;
  body.look = look;
  add_box(body, low, high, true, true);
  return body;
}

Picture picture_of(Stage& stage, const SceneDescription& scene, const ParticleFrame& frame = {}) {
  stage.hud().set_visible(false);
  set_scene(stage, scene);
  stage.scene().set_frame(frame);
  stage.go_home();
  return shoot(stage);
}

// A block of that look, alone on the ground.
Picture picture_of_block(Stage& stage, std::array<float, 3> color, const Look& look) {
  SceneDescription scene;
  scene.spacing = 0.01;
  scene.bounds_min = {-0.2, -0.2, -0.1};
  scene.bounds_max = {0.2, 0.2, 0.2};
  scene.bodies = {box(color, look, {-0.1, -0.1, 0}, {0.1, 0.1, 0.06})};
  return picture_of(stage, scene);
}

// A white tray of liquid with or without a white brick that leaves 8 mm of it above.
SyntheticScene white_tray(const char* look, bool brick) {
  SyntheticScene s = synthetic_scene();
  s.scene.bodies.pop_back();
  s.scene.bodies[0].look = named_look(look).look;
  s.scene.bodies[1].color = {1, 1, 1};
  const Look matt{false, 1, 0, 1.5f, {}, 0, 0};
  if (brick) s.scene.bodies.push_back(box({1, 1, 1}, matt, {-0.05, -0.05, 0.01}, {0.05, 0.05, kDepth - 0.008}));
  return s;
}

TEST(LookImage, HoneyAbsorbsBlueMoreThanRedAndGreenMoreSoWhereItIsDeep) {
  double green_of_red[2];  // blue is gone within millimetres: what is left of it is reflected
  for (const bool brick : {false, true}) {
    Stage stage(small_stage());
    const SyntheticScene s = white_tray("honey", brick);
    const Picture picture = picture_of(stage, s.scene, s.frame);
    const Pixel p = at(picture, stage.project({-0.02, 0.01, kDepth}));
    EXPECT_GT(p.r, p.b + 25) << brick;
    green_of_red[brick] = static_cast<double>(p.g) / p.r;
  }
  EXPECT_LT(green_of_red[false], 0.8 * green_of_red[true]);
}

TEST(LookImage, ClearerLiquidsShowMoreOfWhatLiesInThem) {
  const auto brick_shows = [](const Look& look) {
    Pixel seen[2];
    for (const bool brick : {false, true}) {
      Stage stage(small_stage());
      SyntheticScene s = white_tray("water", brick);
      s.scene.bodies[0].look = look;
      s.scene.bodies[1].color = {0.1f, 0.1f, 0.1f};
      const Picture picture = picture_of(stage, s.scene, s.frame);
      seen[brick] = at(picture, stage.project({-0.02, 0.01, kDepth}));
    }
    return seen[1].g - seen[0].g;
  };
  Look hazy = named_look("water").look;
  hazy.scattering_length = 0.01f;
  const int through_clear = brick_shows(named_look("water").look), through_haze = brick_shows(hazy);
  EXPECT_GT(through_clear, 60);
  EXPECT_LT(through_haze, through_clear / 2);
}

// Matter that bends, absorbs, scatters and reflects nothing is not there: the light behind it is taken from the picture
// and shown again, and the tone curve must give it back.
TEST(LookImage, MatterThatDoesNothingToLightIsNotSeen) {
  Picture pictures[2];
  for (const bool there : {false, true}) {
    Stage stage(small_stage());
    SyntheticScene s = white_tray("water", true);
    s.scene.bodies[0].look = {true, 0.5f, 0, 1, {0, 0, 0}, kMostScatteringLength, 0};
    ParticleFrame frame = s.frame;
    // beside a far one, particles out of sight
    if (!there) std::fill(frame.positions.begin(), frame.positions.end(), 1e6f);
    stage.hud().set_visible(false);
    set_scene(stage, s.scene);
    stage.scene().set_frame(s.frame);
    stage.go_home();
    stage.scene().set_frame(frame);
    pictures[there] = shoot(stage);
  }
  int worst = 0;
  double sum = 0;
  for (std::size_t i = 0; i < pictures[0].rgb.size(); ++i) {
    const int difference = std::abs(pictures[0].rgb[i] - pictures[1].rgb[i]);
    worst = std::max(worst, difference);
    sum += difference;
  }
  // what remains at grazing angles is the reflection of any polished surface; elsewhere rounding alone
  EXPECT_LT(sum / static_cast<double>(pictures[0].rgb.size()), 1.5);
}

TEST(LookImage, AMetalReflectsInItsColorAndPlasticInThatOfTheLight) {
  const osg::Vec3d top(0.02, 0.03, 0.06);
  Look metal, plastic;
  metal.metallic = 1;
  metal.roughness = plastic.roughness = 0.3f;
  Stage first(small_stage()), second(small_stage());
  const Picture red = picture_of_block(first, {1, 0.25f, 0.25f}, metal);
  const Picture black = picture_of_block(second, {0, 0, 0}, plastic);
  const Pixel on_metal = at(red, first.project(top)), on_plastic = at(black, second.project(top));
  EXPECT_GT(on_metal.r, 60);
  EXPECT_GT(on_metal.r, 2 * on_metal.g);
  EXPECT_GT(on_plastic.g, 12) << "black plastic gleams";
  EXPECT_LT(std::abs(on_plastic.r - on_plastic.b), 15);
}

// The brightest that a lying cylinder of white metal gets: some of it mirrors the key light's window.
int brightest_of_cylinder(float roughness) {
  SceneDescription scene;
  scene.spacing = 0.01;
  BodyDescription body;
  body.kind = BodyKind::fixed;
  body.color = {1, 1, 1};
  body.look.metallic = 1;
  body.look.roughness = roughness;
  constexpr int kSides = 48;
  const auto point = [](double x, int i) {
    const double angle = 2 * M_PI * i / kSides;
    return std::array<double, 3>{x, 0.05 * std::cos(angle), 0.05 * std::sin(angle)};
  };
  for (int i = 0; i < kSides; ++i) {
    add_quad(body, {{point(-0.1, i), point(0.1, i), point(0.1, i + 1), point(-0.1, i + 1)}});
    for (const double x : {-0.1, 0.1})  // its ends
      add_quad(body, {{{x, 0, 0}, {x, 0, 0}, point(x, x < 0 ? i + 1 : i), point(x, x < 0 ? i : i + 1)}});
  }
  scene.bodies = {body};
  Stage stage(small_stage());
  const Picture picture = picture_of(stage, scene);
  return *std::ranges::max_element(picture.rgb);
}

TEST(LookImage, LightStaysBelowWhiteHoweverStrong) {
  for (const float roughness : {0.0f, 0.2f, 0.4f}) {
    EXPECT_GT(brightest_of_cylinder(roughness), 200) << roughness;
    EXPECT_LT(brightest_of_cylinder(roughness), 255) << roughness;
  }
}

TEST(LookImage, RoughnessSpreadsAReflection) {
  EXPECT_GT(brightest_of_cylinder(0.05f), brightest_of_cylinder(0.9f) + 20);
}

TEST(LookImage, WoodHasGrain) {
  Stage plain(small_stage(640, 480)), grained(small_stage(640, 480));
  Look look = named_look("wood").look;
  const Picture with = picture_of_block(grained, {0.7f, 0.5f, 0.3f}, look);
  look.grain = 0;
  const Picture without = picture_of_block(plain, {0.7f, 0.5f, 0.3f}, look);
  EXPECT_GT(differing(with, without), 2000);
}

TEST(LookImage, GlassIsSeenThrough) {
  const auto behind = [](const char* look) {
    SceneDescription scene;
    scene.spacing = 0.01;
    scene.bodies = {box({1, 0, 0}, Look{}, {-0.1, 0.05, 0}, {0.1, 0.07, 0.1}),
                    box({0.8f, 0.9f, 0.9f}, named_look(look).look, {-0.1, -0.05, 0}, {0.1, -0.03, 0.1})};
    Stage stage(small_stage());
    const Picture picture = picture_of(stage, scene);
    return at(picture, stage.project({0, -0.05, 0.07}));
  };
  const Pixel glass = behind("glass"), china = behind("china");
  EXPECT_GT(glass.r, glass.g + 40);
  EXPECT_LT(std::abs(china.r - china.g), 25);
}

}  // namespace
}  // namespace palp::test::look_image_test
