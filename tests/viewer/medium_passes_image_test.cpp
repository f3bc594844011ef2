// The passes of media leave out some things, and keep others from one picture to the next: none of it may be seen.
#include <gtest/gtest.h>

#include "tests/viewer/block_scene.h"
#include "tests/viewer/picture_tools.h"

namespace palp::test::medium_passes_image_test {
namespace {

// Where all that is clear has one look, its thickness alone is drawn; a particle that is hardly rougher has looks
// summed up, too.
TEST(MediumPasses, OneLookOfWhatIsClearIsWhatParticlesAddUpTo) {
  for (const char* name : {"water", "honey"}) {
    SyntheticScene s = block(name, {20, 16, 14}, 0.3);
    Picture pictures[2];
    for (const bool other : {false, true}) {
      if (other) {
        BodyDescription speck = s.scene.bodies[0];
        speck.look.roughness += 1e-3f;
        speck.first = --s.scene.bodies[0].count;
        speck.count = 1;
        s.scene.bodies.push_back(speck);
      }
      Stage stage(small_stage(640, 480));
      put_on(stage, s);
      EXPECT_EQ(stage.scene().cloud().one_tint(Medium::clear).has_value(), !other);
      pictures[other] = shoot(stage);
    }
    EXPECT_LE(largest_difference(pictures[0], pictures[1]), 3) << name;
  }
}

// Scalars are kept beside distances only while colours show them: whether they do may change at any time.
TEST(MediumPasses, NumbersMayComeAndGo) {
  for (const char* name : {"batter", "water"}) {
    SyntheticScene s = block(name, {20, 16, 14}, 0.3);
    for (std::size_t i = 0; i < s.frame.scalars.size(); ++i) s.frame.scalars[i] = s.frame.positions[3 * i];
    s.frame.field = ScalarField::speed;
    Stage stage(small_stage());
    put_on(stage, s);
    const auto show = [&](ScalarField field) {
      stage.scene().set_color(field);
      stage.scene().set_frame(s.frame);
      return shoot(stage);
    };
    const Picture looks = show(ScalarField::none), numbers = show(ScalarField::speed);
    EXPECT_GT(largest_difference(looks, numbers), 60);
    const Spot low = find(numbers, bluish);
    EXPECT_GT(low.pixels, 100) << "the slow end of the map";
    EXPECT_LT(low.middle.x(), 0.5 * numbers.width) << "is on the left";
    EXPECT_EQ(largest_difference(looks, show(ScalarField::none)), 0);
    EXPECT_EQ(largest_difference(numbers, show(ScalarField::speed)), 0);
  }
}

// The passes of the smoothing are not cleared between pictures.
TEST(MediumPasses, WhatHasMovedAwayLeavesNothingBehind) {
  for (const char* name : {"batter", "water"}) {
    const SyntheticScene s = block(name, {20, 16, 14}, 0.3);
    Picture pictures[2];
    for (const bool seen_before : {false, true}) {
      Stage stage(small_stage());
      put_on(stage, s);
      if (seen_before) shoot(stage);
      ParticleFrame moved = s.frame;
      for (std::size_t i = 0; i < moved.positions.size(); i += 3) moved.positions[i] += 4 * kSpacing;
      stage.scene().set_frame(moved);
      pictures[seen_before] = shoot(stage);
    }
    // sums of half floats depend on the order of what is summed up, and this on where the eye was
    EXPECT_LE(largest_difference(pictures[0], pictures[1]), 1) << name;
  }
}

}  // namespace
}  // namespace palp::test::medium_passes_image_test
