// Pictures of what flies: drops in place of the surface's spheres, white where a thin liquid is fast.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tests/viewer/block_scene.h"
#include "tests/viewer/picture_tools.h"
#include "viewer/stage.h"

namespace palp::test::spray_image_test {
namespace {

const osg::Vec3d kDrop(0.05, 0.04, 0.11);  // seven spacings above the block [m]

// A block of a liquid and one particle above it, the last one.
SyntheticScene with_drop(const char* name, float foam) {
  SyntheticScene s = block(name);
  s.scene.bodies[0].look.foam = foam;
  for (int a = 0; a < 3; ++a) s.frame.positions.push_back(static_cast<float>(kDrop[a]));
  s.frame.scalars.push_back(0.2f);
  ++s.scene.particle_count;
  ++s.scene.bodies[0].count;
  s.frame.sim_time = 1;
  return s;
}

// Where the particle was a sixtieth of a second before, when it goes so fast [m/s].
ParticleFrame earlier_than(const ParticleFrame& frame, double speed) {
  ParticleFrame earlier = frame;
  earlier.sim_time -= 1.0 / 60;
  earlier.positions[earlier.positions.size() - 3] -= static_cast<float>(speed / 60);
  return earlier;
}

Picture picture_of(Stage& stage, const ParticleFrame& frame, const ParticleFrame* earlier = nullptr) {
  stage.scene().set_frame(frame, earlier);
  return shoot(stage);
}

// The frame without its last particle.
ParticleFrame without_drop(ParticleFrame frame) {
  std::fill(frame.positions.end() - 3, frame.positions.end(), std::numeric_limits<float>::quiet_NaN());
  return frame;
}

double spacing_pixels(Stage& stage) {
  return (stage.project(kDrop + osg::Vec3d(0, 0, kSpacing)) - stage.project(kDrop)).length();
}

// The pixels within three spacings of the drop in which two pictures differ.
Spot change_at_drop(Stage& stage, const Picture& a, const Picture& b) {
  Picture difference = a;
  for (std::size_t i = 0; i < a.rgb.size(); ++i)
    difference.rgb[i] = static_cast<std::uint8_t>(std::abs(a.rgb[i] - b.rgb[i]));
  const osg::Vec2d middle = stage.project(kDrop);
  const double reach = 3 * spacing_pixels(stage);
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      if ((osg::Vec2d(x, y) - middle).length() > reach)
        std::fill_n(difference.rgb.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * a.width + x), 3, 0);
  return find(difference, [](Pixel p) { return std::max({p.r, p.g, p.b}) > 3; });
}

// The pixels of drops that changed a picture, which the white around them does not do as much.
struct Drops {
  int pixels = 0;
  double brightness = 0;  // on average
  double reach = 0;       // from the drop's middle [pixels]
};

Drops drops_in(Stage& stage, const Picture& with, const Picture& without) {
  Drops drops;
  for (int y = 0; y < with.height; ++y)
    for (int x = 0; x < with.width; ++x) {
      if (std::abs(at(with, x, y).g - at(without, x, y).g) < 25) continue;
      ++drops.pixels;
      drops.brightness += at(with, x, y).g;
      drops.reach = std::max(drops.reach, (osg::Vec2d(x + 0.5, y + 0.5) - stage.project(kDrop)).length());
    }
  drops.brightness /= std::max(drops.pixels, 1);
  return drops;
}

// The ball has 0.62 spacings; its rim takes a pixel of half a dozen.
TEST(SprayImage, WhatIsAloneIsABallOfItsVolume) {
  for (const char* name : {"water", "milk"}) {
    SCOPED_TRACE(name);
    Stage stage(small_stage(640, 480));
    const SyntheticScene s = with_drop(name, 1);
    put_on(stage, s);
    EXPECT_EQ(stage.scene().cloud().drops(), 1u);
    const Picture with = shoot(stage);
    const Spot drop = change_at_drop(stage, with, picture_of(stage, without_drop(s.frame)));
    EXPECT_NEAR(drop.radius, 0.62 * spacing_pixels(stage), 1.5);
    EXPECT_LT((drop.middle - stage.project(kDrop)).length(), 1.5);
  }
}

TEST(SprayImage, OnlyWhatIsFastAndThinTurnsWhite) {
  Stage stage(small_stage(640, 480));
  const SyntheticScene s = with_drop("water", 1);
  put_on(stage, s);
  const Picture still = shoot(stage);
  const ParticleFrame resting = earlier_than(s.frame, 0), fast = earlier_than(s.frame, 2);
  EXPECT_EQ(differing(picture_of(stage, s.frame, &resting), still), 0) << "what rests has no foam";
  const Picture white = picture_of(stage, s.frame, &fast);
  const Picture without = picture_of(stage, without_drop(s.frame));
  EXPECT_GT(drops_in(stage, white, without).brightness, drops_in(stage, still, without).brightness + 15);
  EXPECT_EQ(differing(picture_of(stage, s.frame, &fast), white), 0) << "the same frames, the same picture";

  Stage thick(small_stage(640, 480));
  put_on(thick, with_drop("honey", 0));
  const Picture honey = shoot(thick);
  EXPECT_EQ(thick.scene().cloud().drops(), 0u);
  EXPECT_EQ(differing(picture_of(thick, s.frame, &fast), honey), 0) << "thick liquids have no foam";
}

// A particle holds much more than a drop that stays whole when it is fast: its parts are farther apart than it is wide,
// and one sees between them.
TEST(SprayImage, WhatIsFastFallsApart) {
  Stage stage(small_stage(640, 480));
  const SyntheticScene s = with_drop("water", 1);
  put_on(stage, s);
  const double spacing = spacing_pixels(stage);
  const Picture without = picture_of(stage, without_drop(s.frame));
  const auto seen_at = [&](double speed) {
    const ParticleFrame earlier = earlier_than(s.frame, speed);
    return drops_in(stage, picture_of(stage, s.frame, &earlier), without);
  };
  const auto filled = [](const Drops& drops) { return drops.pixels / (M_PI * drops.reach * drops.reach); };
  const Drops slow = seen_at(0), fast = seen_at(2);
  EXPECT_LT(slow.reach, 0.7 * spacing);
  EXPECT_GT(filled(slow), 0.4) << "half of a clear ball is as dark as what is behind it";
  EXPECT_GT(fast.reach, spacing);
  EXPECT_LT(fast.reach, 2 * spacing);
  EXPECT_LT(filled(fast), 0.6 * filled(slow));
}

TEST(SprayImage, NumbersAndBeadsHaveNone) {
  Stage stage(small_stage());
  const SyntheticScene s = with_drop("water", 1);
  put_on(stage, s, ScalarField::speed);
  EXPECT_EQ(stage.scene().cloud().drops(), 0u) << "what colours say must not be hidden";
  stage.scene().set_color(ScalarField::none);
  stage.scene().set_beads(true);
  stage.scene().set_frame(s.frame);
  EXPECT_EQ(stage.scene().cloud().drops(), 0u);
}

// A particle leaves the block: no step of a fiftieth of a spacing changes the picture by much more than others do.
TEST(SprayImage, ADropComesOffWithoutAPop) {
  Stage stage(small_stage(640, 480));
  SyntheticScene s = with_drop("milk", 1);
  put_on(stage, s);
  const double top = kSpacing * 5;
  std::vector<double> changes;
  Picture before;
  for (double gap = 0.8; gap <= 2.0; gap += 0.02) {
    s.frame.positions[s.frame.positions.size() - 3] = static_cast<float>(kSpacing * 6.5);
    s.frame.positions[s.frame.positions.size() - 2] = static_cast<float>(kSpacing * 4.5);
    s.frame.positions[s.frame.positions.size() - 1] = static_cast<float>(top + kSpacing * gap);
    const ParticleFrame earlier = earlier_than(s.frame, 2);
    const Picture now = picture_of(stage, s.frame, &earlier);
    if (!before.rgb.empty()) {
      double change = 0;
      for (std::size_t i = 0; i < now.rgb.size(); ++i) change += std::abs(now.rgb[i] - before.rgb[i]);
      changes.push_back(change);
    }
    before = now;
  }
  const double mean = std::accumulate(changes.begin(), changes.end(), 0.0) / static_cast<double>(changes.size());
  EXPECT_LT(*std::ranges::max_element(changes), 4 * mean);
}

}  // namespace
}  // namespace palp::test::spray_image_test
